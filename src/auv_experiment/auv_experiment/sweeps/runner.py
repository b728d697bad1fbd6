"""
A sweep from its study to its table: kept runs are reused, the others flown, and each is kept as it ends.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from auv_core.cli.tally import Tally
from auv_core.machine.failure import Failure
from auv_core.machine.kept_json import KeptError, remove, words_of_broken
from auv_core.machine.whole_files import write_text
from auv_experiment import results
from auv_experiment.run_key import source_version
from auv_experiment.sweeps.parts import Parts
from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.study import Study
from auv_experiment.sweeps.table import write_table
from auv_experiment.sweeps.worker import Finished

PARTS = "parts"
FAILURES_FILE = "failures.txt"
_SHOWN_PACKAGES = ("numpy", "scipy", "numba", "scikit-fuzzy", "distributed", "pyarrow", "matplotlib")

OnResult = Callable[[PlannedRun, Finished], None]
OnMessage = Callable[[str], None]
Fly = Callable[[Sequence[PlannedRun], OnResult, OnMessage], None]


def run_sweep(
    study: Study,
    runs: Sequence[PlannedRun],
    folder: Path,
    fly: Fly,
    *,
    tally: Tally,
    is_fresh: bool = False,
    on_known: OnResult = lambda run, finished: None,
) -> Path:
    """
    Fly all runs that are not kept from an earlier call, and write the table and the tracebacks of failures.

    Parameters
    ----------
    study, runs : Study, sequence of PlannedRun
        The study and all of its runs.
    folder : Path
        Folder of the sweep.
    fly : callable
        Flies runs, and reports each result and, in one line, other events (`local.fly_here`,
        `cluster.fly_there`); only called if there are runs to fly.
    tally : Tally
        Receives progress and failures.
    is_fresh : bool
        Fly runs again even if they are kept.
    on_known : callable
        Receives each run that is kept or flown, and its outcome.

    Returns
    -------
    path : Path
        The table.

    Raises
    ------
    ConfigError
        If the cluster cannot be reached.
    ClusterError, WorkersError
        If the cluster is lost or cannot fly, or no process of this machine can be started; finished runs are
        kept.
    WriteError
        If a result cannot be written, as on a full disk; finished runs are kept.

    """
    parts = Parts(folder / PARTS)
    by_key = {run.key: run for run in runs}
    found = {} if is_fresh else _kept(parts, by_key, tally.message)
    for key, finished in found.items():
        on_known(by_key[key], finished)
    missing = sorted((run for run in by_key.values() if run.key not in found), key=lambda run: -run.effort)
    remark = f", and {len(found)} kept from an earlier call" if found else ""
    tally.start(len(missing), sum(run.effort for run in missing), remark)
    done = 0.0

    def keep(run: PlannedRun, finished: Finished) -> None:
        nonlocal done
        found[run.key] = finished
        on_known(run, finished)
        if finished.is_lasting:
            parts.put(run.key, finished)
        if finished.error:
            tally.failed(name_of(run), Failure(finished.error, finished.traceback))
        done += run.effort
        tally.finished()
        tally.advance(done)

    if missing:
        fly(missing, keep, tally.message)
    rows = [(run, found[run.key]) for run in runs]
    path = write_table(folder, study, rows, _making())
    _write_failures(folder / FAILURES_FILE, rows)
    parts.forget_old()
    return path


def _kept(parts: Parts, keys: Iterable[str], on_message: OnMessage) -> dict[str, Finished]:
    """Return the kept results by key; drop damaged ones, and report each in one line."""
    found: dict[str, Finished] = {}
    broken: list[str] = []
    for key in keys:
        try:
            if (kept := parts.get(key)) is not None:
                found[key] = kept
        except KeptError as error:
            broken.append(f"{parts.path(key)} ({error})")
            remove(parts.path(key))
    if broken:
        on_message(f"warning: {words_of_broken(broken)}")
    return found


def name_of(run: PlannedRun) -> str:
    """Return a run as text: its row, its parameters and its seed."""
    words = [*(f"{path}={value}" for path, value in run.parameters.items()), f"seed={run.seed}"]
    return f"run {run.index} ({', '.join(words)})"


def _write_failures(file: Path, rows: Sequence[tuple[PlannedRun, Finished]]) -> None:
    failed = [(run, finished) for run, finished in rows if finished.error]
    file.unlink(missing_ok=True)
    if failed:
        text = "\n".join(f"== {name_of(run)}\n{finished.traceback}" for run, finished in failed)
        write_text(file, text)


def _making() -> dict[str, str]:
    """Return the versions that runs were made with, by name; they do not depend on the number of workers."""
    packages = results.package_versions()
    making = {"Python": platform.python_version()}
    making.update({name: packages[name] for name in _SHOWN_PACKAGES if name in packages})
    making["source"] = source_version()
    git = results.git_state(Path(__file__).resolve())
    if git:
        making["revision"] = f"{git['revision']}{', with local changes' if git['has_local_changes'] else ''}"
    return making
