"""A sweep from its study to its table: what is kept is taken, the rest flown, each run kept as it ends."""

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
    Fly what is not kept from an earlier call, and write the table and the tracebacks of what failed.

    Parameters
    ----------
    study, runs : Study, sequence of PlannedRun
        What is asked for, and all runs of it.
    folder : Path
        Folder of the sweep.
    fly : callable
        Flies runs, tells what came of each, and tells in one line what else happens (`local.fly_here`,
        `cluster.fly_there`); only called if there is something to fly.
    tally : Tally
        Told what happens.
    is_fresh : bool
        Fly runs that are kept, too.
    on_known : callable
        Told each run that is kept or flown, and its outcome.

    Returns
    -------
    path : Path
        The table.

    Raises
    ------
    ConfigError
        When the cluster cannot be reached.
    ClusterError, WorkersError
        When it is lost or cannot fly, or no process of this machine can; what is finished is kept.
    WriteError
        When a result cannot be written, as on a full disk; what is finished is kept.

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
    """Return what is kept by key; forget what does not hold, and say so in one line."""
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
    """Return a run in words: its row, what varies, and its seed."""
    words = [*(f"{path}={value}" for path, value in run.parameters.items()), f"seed={run.seed}"]
    return f"run {run.index} ({', '.join(words)})"


def _write_failures(file: Path, rows: Sequence[tuple[PlannedRun, Finished]]) -> None:
    failed = [(run, finished) for run, finished in rows if finished.error]
    file.unlink(missing_ok=True)
    if failed:
        text = "\n".join(f"== {name_of(run)}\n{finished.traceback}" for run, finished in failed)
        write_text(file, text)


def _making() -> dict[str, str]:
    """Return what runs were made with, by name; the same however many workers there are."""
    packages = results.package_versions()
    making = {"Python": platform.python_version()}
    making.update({name: packages[name] for name in _SHOWN_PACKAGES if name in packages})
    making["source"] = source_version()
    git = results.git_state(Path(__file__).resolve())
    if git:
        making["revision"] = f"{git['revision']}{', with local changes' if git['has_local_changes'] else ''}"
    return making
