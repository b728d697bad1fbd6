"""Flies the runs that chapters need, each once, in worker processes, and keeps them for later calls."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

from auv_core.cli.tally import Tally
from auv_core.machine.failure import Failure
from auv_core.machine.kept_json import KeptError, words_of_broken
from auv_core.machine.whole_files import WriteError
from auv_core.machine.workers import Advance, spread
from auv_core.params import ConfigError
from auv_experiment.inprocess.evaluated_run import load_source, run_evaluated
from auv_thesis.items import RunSpec
from auv_thesis.runs.store import ResolvedRun, Store, resolve_run

_EFFORT_PER_S = 150_000.0
"""Evaluations of a law per second and process, a rough value for the case that no run is kept."""
_TOLD_FROM_S = 60.0
_MANY_RUNS = 200


@dataclass
class Flown:
    """
    The results of a set of runs.

    Attributes
    ----------
    resolved : dict
        Every run that could be resolved, by spec. Specs that resolve to the same scenario share a key.
    failed : dict
        The failure of every run that could not be resolved or flown, by spec.
    times_s : dict
        Wall and processor time of each run when it was flown (s), by key.
    kept : set of str
        Keys of the runs that were kept from an earlier call.

    """

    resolved: dict[RunSpec, ResolvedRun] = field(default_factory=dict)
    failed: dict[RunSpec, Failure] = field(default_factory=dict)
    times_s: dict[str, tuple[float, float]] = field(default_factory=dict)
    kept: set[str] = field(default_factory=set)


def fly_all(
    specs: Iterable[RunSpec], store: Store, *, n_workers: int, tally: Tally, is_fresh: bool = False
) -> Flown:
    """
    Fly every run once, the longest first, except those that are kept from an earlier call.

    A failed run is reported and does not stop the others, unless its result cannot be written.

    Parameters
    ----------
    specs : iterable of RunSpec
        Runs that are needed; equal ones count once.
    store : Store
        Store of finished runs.
    n_workers : int
        Number of processes.
    tally : Tally
        Receives progress and failures.
    is_fresh : bool
        Fly runs again even if they are kept.

    Raises
    ------
    WriteError
        If a run cannot be written, as on a full disk; finished runs are kept.
    WorkersError
        If no worker process can be started.

    """
    flown = Flown()
    _plan(list(dict.fromkeys(specs)), flown, tally)
    by_key = _by_key(flown)
    flown.kept = set() if is_fresh else _kept(store, by_key.values(), tally)
    missing = sorted((run for key, run in by_key.items() if key not in flown.kept), key=_longest_first)
    for key in flown.kept:
        if (times_s := store.times_s(key)) is not None:
            flown.times_s[key] = times_s
    kept = f", and {len(flown.kept)} kept from an earlier call" if flown.kept else ""
    known = [(by_key[key].cost, wall_s) for key, (wall_s, _) in flown.times_s.items()]
    remark = kept + _duration_words([run.cost for run in missing], known, n_workers)
    tally.start(len(missing), sum(run.cost for run in missing), remark)

    def note(index: int, result: Failure | str) -> None:
        run = missing[index]
        if isinstance(result, Failure):
            failed = [spec for spec, resolved in flown.resolved.items() if resolved.key == run.key]
            flown.failed.update(dict.fromkeys(failed, result))
            tally.failed(str(run.spec), result)
        elif result:
            raise WriteError(result)
        tally.finished()

    load_source()
    spread(
        [partial(_fly, run, store) for run in missing],
        n_workers,
        on_result=note,
        on_progress=tally.advance,
        on_message=tally.message,
    )
    for key in by_key:
        if (times_s := store.times_s(key)) is not None:
            flown.times_s[key] = times_s
    return flown


def _duration_words(costs: Sequence[float], known: Sequence[tuple[float, float]], n_workers: int) -> str:
    """
    Return how long runs will take, roughly; '' for less than a minute.

    Parameters
    ----------
    costs : sequence of float
        Expected efforts of the runs that are missing.
    known : sequence of (2,) tuples
        Effort and wall time (s) of runs that are kept.
    n_workers : int
        Number of processes.

    """
    flown_s = sum(wall_s for _, wall_s in known)
    effort_per_s = sum(cost for cost, _ in known) / flown_s if flown_s > 0.0 else _EFFORT_PER_S
    duration_s = max(sum(costs) / n_workers, max(costs, default=0.0)) / effort_per_s
    if duration_s < _TOLD_FROM_S:
        return ""
    hours, minutes = divmod(round(duration_s / 60.0), 60)
    words = f"{hours} h {minutes} min" if hours else f"{minutes} min"
    return f"; they take about {words} in {n_workers} process{'es' if n_workers != 1 else ''}"


def _by_key(flown: Flown) -> dict[str, ResolvedRun]:
    """Return each run once; of two specs for one run, return the one that keeps its recording."""
    by_key: dict[str, ResolvedRun] = {}
    for run in flown.resolved.values():
        if run.key not in by_key or run.spec.keep_recording:
            by_key[run.key] = run
    return by_key


def _kept(store: Store, runs: Iterable[ResolvedRun], tally: Tally) -> set[str]:
    """Return the keys of the runs that are kept; report in one line each run that is damaged."""
    kept: set[str] = set()
    broken: list[str] = []
    for run in runs:
        try:
            if store.has(run):
                kept.add(run.key)
        except KeptError as error:
            broken.append(f"{store.folder / run.key} ({error})")
    if broken:
        tally.message(f"warning: {words_of_broken(broken)}")
    return kept


def _plan(specs: Sequence[RunSpec], flown: Flown, tally: Tally) -> None:
    if len(specs) > _MANY_RUNS:
        tally.message(f"checking the scenarios of {len(specs)} runs")
    for spec in specs:
        try:
            flown.resolved[spec] = resolve_run(spec)
        except ConfigError as error:
            flown.failed[spec] = Failure(str(error), "")
            tally.failed(str(spec), flown.failed[spec])


def _longest_first(run: ResolvedRun) -> float:
    return -run.cost


def _fly(run: ResolvedRun, store: Store, advance: Advance) -> str:
    """Fly a run and keep it; called in a worker. Return why it cannot be kept, '' if it is kept."""
    from auv_experiment.metrics.run import metrics_to_json

    reached_s = 0.0

    def on_progress(time_s: float) -> None:
        nonlocal reached_s
        advance(run.cost * (time_s - reached_s) / run.scenario.duration_s)
        reached_s = time_s

    flown = run_evaluated(run.scenario, on_progress=on_progress)
    metrics = metrics_to_json(flown.metrics)
    try:
        store.put(run, flown.recording, metrics, wall_s=flown.wall_s, cpu_s=flown.cpu_s)
    except WriteError as error:
        return str(error)
    on_progress(run.scenario.duration_s)
    return ""
