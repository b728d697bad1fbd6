"""`./scripts/sweep`: fly a study on all cores or on a cluster, and show the results."""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from auv_core.cli.failures import DONE, FAILED, answered
from auv_core.cli.one_line_parser import MOST_WORKERS, OneLineParser, fail, read_argument, whole_number
from auv_core.machine.file_locks import lock_file
from auv_core.machine.processors import processor_count
from auv_core.params import ConfigError
from auv_experiment.figures.formats import add_format_option
from auv_experiment.results import FIGURES, ResultsError, make_folder
from auv_experiment.sweeps.study import Study, list_studies, load_study

if TYPE_CHECKING:
    from auv_experiment.sweeps.patience import Patience
    from auv_experiment.sweeps.runner import Fly

_OUT = Path("results/sweeps")

_HELP = """\
Fly a study: a grid or a sample of scenarios, each with many seeds, in one process per
run without ROS; on all cores of this machine, or on an existing Dask cluster.
"""

_EPILOG = """\
how it works:
  Every run is resolved and checked before the first is flown. Each is kept as it ends:
  if a sweep was interrupted, the same command continues it. Finished runs are reused
  until the scenario, a law, a model or a numerical package changes.
  A failed run does not stop the others, nor does a worker that dies or is stopped, nor
  a run that never ends (see --limit-s). Each folder takes one sweep at a time.

results:
  DIR/runs.parquet    one row per run: parameters, seed, status, every metric
  DIR/summary.csv     mean, confidence interval and range of every metric at every point
  DIR/figures/*       the metrics of the study, with intervals
  DIR/index.html      figures and tables on one self-contained page
  DIR/failures.txt    tracebacks of failures; only if something failed
  DIR/parts/          finished runs, for the next call

exit status:
  0    done
  1    a run failed (the table tells which, and why), no worker could start, or the
       cluster was lost
  2    bad input; nothing was flown
  3    a result cannot be written, as on a full disk; finished runs are kept
  130  Ctrl-C; finished runs are kept, and the next call continues from there

examples:
  ./scripts/sweep --list                        list the built-in studies
  ./scripts/sweep safety --check                count and check the runs; fly nothing
  ./scripts/sweep safety                        on all cores
  ./scripts/sweep my_study.yaml --scheduler tcp://10.0.0.5:8786
  ./scripts/sweep --summarise results/sweeps/safety --format pdf   page and figures again
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    return answered(lambda: _do(_parser().parse_args(arguments)), (ConfigError, ResultsError))


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="./scripts/sweep",
        description=_HELP,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "study", nargs="?", metavar="STUDY", help="name of a built-in study, or path of a .yaml file"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help=f"folder (default: {_OUT}/<name of the study>)"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=partial(whole_number, most=MOST_WORKERS),
        default=processor_count(),
        metavar="N",
        help="number of processes (default: one per processor, %(default)s)",
    )
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address (tcp://host:port) or scheduler file (*.json) of a Dask cluster to fly on",
    )
    parser.add_argument(
        "--limit-s",
        type=_seconds,
        metavar="S",
        help="end a run that takes longer than this (s), and count it as failed "
        "(default: 20 times the median of the others, at least 300 s; a cluster has no limit)",
    )
    parser.add_argument("--fresh", action="store_true", help="fly everything again, kept runs too")
    add_format_option(parser)
    other = parser.add_mutually_exclusive_group()
    other.add_argument("--list", action="store_true", help="list the built-in studies")
    other.add_argument("--check", action="store_true", help="resolve and check every run; fly nothing")
    other.add_argument(
        "--summarise",
        type=Path,
        metavar="DIR",
        help="make page, figures and summary again from DIR/runs.parquet",
    )
    return parser


def _seconds(text: str) -> float:
    return read_argument(
        text, float, lambda value: 1.0 <= value < math.inf, "a number of seconds, at least 1"
    )


def _do(options: argparse.Namespace) -> int:
    if options.list:
        for name, title in list_studies():
            print(f"{name:<16} {title}")
        return DONE
    if options.summarise is not None:
        return _summarise(options.summarise, options.formats)
    if options.study is None:
        raise ConfigError(
            f"study: missing; allowed: {', '.join(name for name, _ in list_studies())}, or a path"
        )
    return _sweep(load_study(options.study), options)


def _sweep(study: Study, options: argparse.Namespace) -> int:
    from auv_experiment.sweeps.plan import plan_runs

    if options.scheduler and options.limit_s is not None:
        raise ConfigError(
            f"--limit-s {options.limit_s:g}: not allowed with --scheduler; allowed: for runs on this machine"
        )
    print(f"{study.name}: {study.title}\n{study.n_runs} runs to check", flush=True)
    runs = plan_runs(study)
    if options.check:
        n_points = len(runs) // len(study.seeds)
        print(f"all allowed: {n_points} points, {len(study.seeds)} seeds each; nothing was flown")
        return DONE
    from auv_core.cli.tally import Tally
    from auv_core.machine.failure import WorkersError
    from auv_experiment.sweeps.patience import Patience
    from auv_experiment.sweeps.runner import run_sweep

    folder = options.out or _OUT / study.name
    make_folder(folder)
    patience = Patience(options.limit_s)
    try:
        with _alone_in(folder), Tally("runs") as tally:
            run_sweep(
                study,
                runs,
                folder,
                _way_to_fly(options, patience),
                tally=tally,
                is_fresh=options.fresh,
                on_known=patience.note,
            )
    except WorkersError as error:
        return fail(FAILED, f"{error}; finished runs are kept for the next call")
    return _summarise(folder, options.formats)


@contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """Lock a folder against other sweeps; the kernel releases the lock if this process is killed."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except PermissionError:  # a system that cannot open folders
        yield
        return
    try:
        _lock(descriptor, folder)
        yield
    finally:
        os.close(descriptor)


def _lock(descriptor: int, folder: Path) -> None:
    try:
        lock_file(descriptor)
    except BlockingIOError:
        raise ResultsError(
            f"--out {str(folder)!r}: another sweep is flying into it; allowed: a folder of its own"
        ) from None
    except OSError:  # a file system that cannot lock folders
        return


def _way_to_fly(options: argparse.Namespace, patience: Patience) -> Fly:
    """Return the function that flies runs; Dask is loaded only for a cluster."""
    from auv_experiment.sweeps.local import fly_here

    if not options.scheduler:
        return partial(fly_here, n_workers=options.workers, patience=patience)
    from auv_experiment.sweeps.cluster import fly_there

    return partial(fly_there, scheduler=options.scheduler)


def _summarise(folder: Path, formats: Sequence[str]) -> int:
    from auv_experiment.metrics.own import FAILED as OWN_FAILED
    from auv_experiment.sweeps.figures import write_figures
    from auv_experiment.sweeps.page import failed_rows, write_page
    from auv_experiment.sweeps.runner import FAILURES_FILE
    from auv_experiment.sweeps.summary import shown_metrics_of, write_differences, write_summary
    from auv_experiment.sweeps.table import TABLE_FILE, read_table

    table = read_table(folder)
    metrics = shown_metrics_of(table)
    write_summary(folder, table)
    write_differences(folder, table)
    figures = write_figures(folder / FIGURES, table, metrics, formats)
    page = write_page(folder, table, metrics, figures)
    for line, count in Counter(filter(None, table.columns.get(OWN_FAILED, ()))).items():
        print(f"warning: own metrics failed in {count} of {table.n_runs} runs: {line}", file=sys.stderr)
    print(f"table: {folder / TABLE_FILE}\npage:  {page}", flush=True)
    if failed := len(failed_rows(table)):
        return fail(FAILED, f"{failed} of {table.n_runs} runs failed; see {folder / FAILURES_FILE}")
    return DONE


if __name__ == "__main__":
    sys.exit(main())
