"""`./scripts/reproduce`: repeat the simulations of the thesis, and compare the results."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from auv_core.cli.failures import DONE, FAILED, answered
from auv_core.cli.one_line_parser import MOST_WORKERS, OneLineParser, fail, whole_number
from auv_core.machine.failure import WorkersError
from auv_core.machine.processors import processor_count
from auv_core.machine.whole_files import write_text
from auv_core.params import ConfigError
from auv_experiment import results
from auv_experiment.figures.formats import add_format_option
from auv_thesis.items import Chapter, ChapterError, chapters, choose, with_seeds

if TYPE_CHECKING:
    from auv_thesis.page.made import MadeChapter
    from auv_thesis.runs.runner import Flown

MOST_SEEDS = 100
FEW_SEEDS = 2
RUNS = "runs"
FAILURES_FILE = "failures.txt"

_HELP = """\
Repeat the simulations of the thesis: draw its figures from our own runs, fill its
tables with its numbers and ours side by side, and judge its claims by the results.
"""

_EPILOG = """\
how it works:
  Each figure, table and claim names the runs that it needs. They are flown in one
  process each, without ROS, in continuous time if the scenario says so; the longest
  first, one per worker. A run that two figures need is flown once.
  Finished runs are kept in DIR/runs and reused until the scenario, a law, a model or
  the version of a numerical package changes; --fresh flies everything again.

results:
  DIR/index.html      the page: one self-contained file, to send or print
  DIR/summary.json    the same content as data
  DIR/figures/*       the figures as single files
  DIR/chapters/*.md   claims and tables of a chapter, to paste into a document
  DIR/failures.txt    tracebacks of failures; only if something failed
  A run that fails does not stop the others. The page marks each item that depends on it.

exit status:
  0    done; a claim that does not hold is a result, not a failure
  1    a run failed, or a figure, table or claim could not be made; the page says which;
       or no worker could start
  2    bad input; nothing was flown
  3    a result cannot be written, as on a full disk; finished runs are kept
  130  Ctrl-C; finished runs are kept, and the next call continues from there

examples:
  ./scripts/reproduce                    everything
  ./scripts/reproduce --list             list chapters and items; fly nothing
  ./scripts/reproduce --only ch3 --format pdf        one chapter, its figures for a paper, too
  ./scripts/reproduce --only ch2,ch4 --out /tmp/two_chapters
  ./scripts/reproduce --only acoustics --seeds 100   the studies with all their seeds
  ./scripts/reproduce --only envelope --seeds 100    the safety envelope; hours, Ctrl-C and go on
  ./scripts/reproduce --only torpedoes --seeds 50    torpedoes in lanes; an hour or more
  ./scripts/reproduce --docs             write equations.md and figures.md of docs/reference again
"""


def main(arguments: Sequence[str] | None = None, found: Sequence[Chapter] | None = None) -> int:
    """
    Run the command; return its exit status. `found` are the chapters, by default those of this package.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    return answered(lambda: _do(given, found), (ConfigError, ChapterError, results.ResultsError))


def _do(arguments: list[str], found: Sequence[Chapter] | None) -> int:
    options = _parser().parse_args(arguments)
    known = chapters() if found is None else tuple(found)
    if options.docs:
        return _write_documents(known)
    chosen = with_seeds(_chosen(known, options.only), options.seeds)
    if options.list:
        return _list(chosen)
    try:
        return _reproduce(chosen, options, arguments)
    except WorkersError as error:
        return fail(FAILED, f"{error}; finished runs are kept for the next call")


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="./scripts/reproduce",
        description=_HELP,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="CHAPTER",
        help="only this chapter, by its name in --list; repeatable, or several with commas",
    )
    parser.add_argument(
        "--workers",
        type=_workers,
        default=processor_count(),
        metavar="N",
        help="number of processes (default: one per processor, %(default)s)",
    )
    parser.add_argument(
        "--seeds",
        type=_seeds,
        default=FEW_SEEDS,
        metavar="N",
        help=f"how many seeds the studies fly, up to {MOST_SEEDS} (default: %(default)s, for a first look)",
    )
    parser.add_argument("--fresh", action="store_true", help="fly everything again, kept runs too")
    parser.add_argument(
        "--out",
        default=Path("results/reproduction"),
        metavar="DIR",
        type=Path,
        help="folder of the page and the kept runs (default: %(default)s)",
    )
    add_format_option(parser)
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--list", action="store_true", help="list chapters, figures, tables and claims; fly nothing"
    )
    group.add_argument(
        "--docs", action="store_true", help="write equations.md and figures.md of docs/reference; fly nothing"
    )
    return parser


def _workers(text: str) -> int:
    return whole_number(text, MOST_WORKERS)


def _seeds(text: str) -> int:
    return whole_number(text, MOST_SEEDS)


def _chosen(known: Sequence[Chapter], only: Sequence[str]) -> tuple[Chapter, ...]:
    keys = [key.strip() for text in only for key in text.split(",")]
    try:
        return choose(known, keys)
    except ChapterError as error:
        raise ChapterError(f"--only: {error}") from None


def _list(chosen: Sequence[Chapter]) -> int:
    for chapter in chosen:
        print(f"{chapter.key}  {chapter.title} ({len(chapter.runs)} runs)")
        for figure in chapter.figures:
            print(f"    figure {figure.number:<8} {figure.title}")
        for table in chapter.tables:
            print(f"    table  {table.number:<8} {table.title}")
        for claim in chapter.claims:
            print(f"    claim  {claim.number:<8} {claim.text}")
    return DONE


def _write_documents(known: Sequence[Chapter]) -> int:
    from auv_thesis.page.documents import write_documents

    for path in write_documents(known):
        print(path)
    return DONE


def _reproduce(chosen: Sequence[Chapter], options: argparse.Namespace, arguments: list[str]) -> int:
    from auv_core.cli.tally import Tally
    from auv_thesis.page.made import evaluate
    from auv_thesis.page.making import making_of
    from auv_thesis.page.page import write_page
    from auv_thesis.runs.runner import fly_all
    from auv_thesis.runs.store import Store

    start_s = time.monotonic()
    folder, n_workers = options.out, options.workers
    results.make_folder(folder)
    store = Store(folder / RUNS)
    specs = [spec for chapter in chosen for spec in chapter.runs]
    with Tally("runs") as tally:
        flown = fly_all(specs, store, n_workers=n_workers, tally=tally, is_fresh=options.fresh)
    with Tally("figures, tables and claims") as tally:
        all_made = evaluate(chosen, flown, store, n_workers=n_workers, tally=tally, formats=options.formats)
    store.forget_old()
    command = shlex.join(["./scripts/reproduce", *arguments])
    wall_s = time.monotonic() - start_s
    page = write_page(folder, all_made, making_of(command, flown, n_workers=n_workers, wall_s=wall_s))
    _print_counts(all_made)
    print(f"page: {page}", flush=True)
    return _tell_failures(folder / FAILURES_FILE, flown, all_made)


def _print_counts(all_made: Sequence[MadeChapter]) -> None:
    from auv_thesis.page.overview import counts

    for kind, found in counts(all_made).items():
        words = ", ".join(f"{count} {word}" for word, count in found.items() if count)
        if words:
            print(f"{kind + ':':<10}{words}")


def _tell_failures(file: Path, flown: Flown, all_made: Sequence[MadeChapter]) -> int:
    """Write the tracebacks of everything that failed; return the exit status."""
    from auv_thesis.page.made import name_of

    failures = [(f"run {spec}", failure) for spec, failure in flown.failed.items()]
    failures += [
        (name_of(made.item), made.failure)
        for chapter in all_made
        for made in chapter.all
        if made.failure is not None
    ]
    file.unlink(missing_ok=True)
    if not failures:
        return DONE
    text = "\n".join(f"== {name}\n{failure.traceback or failure.line}\n" for name, failure in failures)
    write_text(file, text)
    return fail(FAILED, f"{len(failures)} items could not be made; see {file}")


if __name__ == "__main__":
    sys.exit(main())
