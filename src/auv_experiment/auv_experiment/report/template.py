"""The page of a report, with places for what fills it."""

from __future__ import annotations

from string import Template

from auv_experiment.report.html import page_top

PAGE = Template(
    page_top("58rem")
    + """\
h1 { font-size: 1.5rem; line-height: 1.25; margin: 0 0 .3rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid #bbb; padding-bottom: .2rem; }
.facts { color: #555; margin: 0 0 1rem; }
.verdicts { list-style: none; margin: 1rem 0; padding: 0; }
.verdicts li { border-left: .35rem solid #999; padding: .15rem 0 .15rem .7rem; margin: .45rem 0; }
.verdicts li.good { border-color: #1d7a46; }
.verdicts li.bad { border-color: #b3261e; background: #fdf0ef; }
.verdicts b { display: inline-block; min-width: 2.6rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #ddd; }
td.value, th.value { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
code, pre { font: .85rem/1.45 ui-monospace, "DejaVu Sans Mono", Consolas, monospace; }
td code { color: #555; }
pre { background: #f4f4f4; padding: .7rem .8rem; overflow-x: auto; border-radius: .3rem; }
figure { margin: 1.6rem 0; break-inside: avoid; }
img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
figcaption { font-size: .92rem; margin-top: .4rem; }
details { margin: 1rem 0; }
summary { cursor: pointer; font-weight: 600; }
@media (max-width: 40rem) { .key { display: none; } body { padding: .8rem .7rem 2rem; } }
@media print { body { max-width: none; font-size: 10pt; } tr { break-inside: avoid; }
  pre { white-space: pre-wrap; } }
</style>
</head>
<body>
<h1>$title</h1>
<p class="facts">$facts</p>
<p>$flown</p>
<h2>Result</h2>
<ul class="verdicts">
$verdicts
</ul>
$figures
<h2>Numbers</h2>
<div class="scroll">
$numbers
</div>
<h2>Do it again</h2>
$again
<h2>Made with</h2>
<div class="scroll">
$versions
</div>
<details><summary>The scenario, resolved</summary>
<pre>$scenario</pre>
</details>
</body>
</html>
"""
)
