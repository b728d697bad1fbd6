"""Parts of self-contained pages: head and styles, embedded images, tables of pairs."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping

_HEAD = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<title>$title</title>
<style>
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 1.2rem 1rem 3rem; color: #1a1a1a; background: #fff;
  font: 1rem/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .3rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .6rem; border-bottom: 1px solid #bbb; padding-bottom: .2rem; }
h3 { font-size: 1.05rem; margin: 1.6rem 0 .5rem; }
a { color: #0b4f83; }
.facts { color: #555; margin: 0 0 1rem; }
.scroll { overflow-x: auto; margin: 1.2rem 0 0; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
caption { text-align: left; font-weight: 600; padding: .2rem 0; }
th, td { text-align: left; vertical-align: top; padding: .3rem .7rem .3rem 0; border-bottom: 1px solid #ddd; }
th[scope=row] { font-weight: 400; }
td.value, th.value { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
td.words { text-align: right; overflow-wrap: anywhere; }
td.number { font-variant-numeric: tabular-nums; }
.counts { width: auto; }
.mark { white-space: nowrap; font-weight: 600; }
.verdicts { list-style: none; margin: 1rem 0; padding: 0; }
.verdicts li { border-left: .35rem solid #999; padding: .15rem 0 .15rem .7rem; margin: .45rem 0; }
.verdicts li.good { border-color: #1d7a46; }
.verdicts li.bad { border-color: #b3261e; background: #fdf0ef; }
.verdicts b { display: inline-block; min-width: 2.6rem; }
.claim { border-left: .35rem solid #999; padding: .1rem 0 .1rem .8rem; margin: 1rem 0; break-inside: avoid; }
.claim p { margin: .2rem 0; }
.claim .number { color: #555; margin-right: .3rem; }
.holds { border-color: #1d7a46; }
.holds-in-part { border-left-style: double; border-color: #8a6100; }
.does-not-hold { border-left-style: dotted; border-color: #b3261e; }
.failure { border: 2px solid #b3261e; padding: .2rem 1rem .6rem; }
.failure h2 { border: 0; margin: .6rem 0; }
ul.claims { margin: .3rem 0; padding-left: 1.2rem; }
.contents li { margin: .35rem 0; }
td code { color: #555; }
code, pre { font: .85rem/1.45 ui-monospace, "DejaVu Sans Mono", Consolas, monospace; }
pre { background: #f4f4f4; padding: .6rem .8rem; overflow-x: auto; border-radius: .3rem; }
figure { margin: 1.8rem 0; break-inside: avoid; }
figure .scroll { margin: 0; }
img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
figcaption { font-size: .92rem; margin-top: .4rem; }
details { margin: .4rem 0; color: #444; font-size: .9rem; }
summary { cursor: pointer; }
@media (max-width: 40rem) { body { padding: .8rem .7rem 2rem; } .key { display: none; }
  figure img { max-width: none; width: 34rem; } }
@media print { body { max-width: none; font-size: 10pt; } tr { break-inside: avoid; } a { color: inherit; }
  .chapter { break-before: page; } pre { white-space: pre-wrap; } details { display: none; } }
</style>
</head>"""


def head(title: str) -> str:
    """Return a page up to its body; the page cannot fetch or run anything."""
    return _HEAD.replace("$title", html.escape(title))


def embedded_png(data: bytes, words: str) -> str:
    """Return an embedded image that scrolls on narrow pages; `words` are its alternative text."""
    text = base64.b64encode(data).decode("ascii")
    return f'<div class="scroll"><img alt="{html.escape(words)}" src="data:image/png;base64,{text}"></div>'


def pairs_table(pairs: Mapping[str, str]) -> str:
    """Return a table of two columns."""
    rows = (
        f"<tr><th scope='row'>{html.escape(key)}</th><td>{html.escape(value)}</td></tr>"
        for key, value in pairs.items()
    )
    return f"<table>\n{chr(10).join(rows)}\n</table>"
