"""Formats of figures, as an option of the commands that make them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from auv_core.cli.one_line_parser import refusal

PAGE_FORMAT = "png"
FORMATS = (PAGE_FORMAT, "pdf", "svg")
"""PNG is drawn for pages, the others for one column of a paper (3.5 in, 8 pt)."""


def add_format_option(parser: argparse.ArgumentParser) -> None:
    """Give a parser the option ``--format``; its value is `formats`."""
    parser.add_argument(
        "--format",
        dest="formats",
        type=_formats,
        default=(PAGE_FORMAT,),
        metavar="FORMAT,...",
        help="formats of the figures, separated by commas: png, and for one column of a paper pdf and svg "
        "(default: png, which is always made)",
    )


def _formats(text: str) -> tuple[str, ...]:
    given = text.split(",")
    if not set(given) <= set(FORMATS):
        raise refusal(text, f"{', '.join(FORMATS)}, and several with commas")
    return with_page_format(given)


def with_page_format(formats: Sequence[str]) -> tuple[str, ...]:
    """Return the formats, each once, with that of pages first, since a page embeds its figures."""
    return tuple(dict.fromkeys((PAGE_FORMAT, *formats)))
