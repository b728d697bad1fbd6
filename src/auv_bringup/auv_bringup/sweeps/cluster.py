"""
Runs on a Dask cluster that exists.

Results come back through Dask, so no folder need be shared. A run whose worker dies is given to another one,
by Dask; what dies with every worker is flown once more when nothing else is, so that only the run that kills
its worker fails and not one that happened to wait behind it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue

from distributed import Client, Future, KilledWorker
from distributed.comm import get_address_host_port

from auv_bringup.failures import one_line
from auv_bringup.run_key import source_version
from auv_bringup.sweeps.plan import PlannedRun
from auv_bringup.sweeps.worker import Finished, SourceMismatchError, fly_run
from auv_bringup.workers import WorkersError
from auv_core.params import ConfigError

_LEAST_SUBMITTED = 500
_SUBMITTED_PER_THREAD = 4
_CONNECT_TIMEOUT_S = 10
_LOOK_EVERY_S = 5.0
_LOOKS_OF_A_DROUGHT = 3
_ANSWER_TIMEOUT_S = 30.0

_UNREACHABLE = (OSError, ValueError, LookupError, TypeError, RuntimeError)
"""What Dask raises; TypeError for a tls:// address when no certificate is configured."""
_LOST = "the scheduler is gone"

OnResult = Callable[[PlannedRun, Finished], None]
OnDrought = Callable[[str], None]


class ClusterError(WorkersError):
    """A cluster that is lost or cannot fly; the message is one line."""


def fly_there(
    runs: Sequence[PlannedRun], on_result: OnResult, on_drought: OnDrought, *, scheduler: str
) -> None:
    """
    Fly runs on the Dask cluster of a scheduler; see `remote_client` and `fly_all`.

    Raises
    ------
    ConfigError, ClusterError
        As these two do.

    """
    with remote_client(scheduler) as client:
        fly_all(client, runs, on_result, on_drought)


@contextmanager
def remote_client(scheduler: str) -> Iterator[Client]:
    """
    Connect to the scheduler at an address, or named by a scheduler file (*.json).

    Raises
    ------
    ConfigError
        When it cannot be reached.

    """
    try:
        address = scheduler
        if scheduler.endswith(".json"):
            address = str(json.loads(Path(scheduler).read_text(encoding="utf-8"))["address"])
        get_address_host_port(address)
        client = Client(address, timeout=_CONNECT_TIMEOUT_S, set_as_default=False)
    except _UNREACHABLE as error:
        raise ConfigError(f"--scheduler {scheduler!r}: cannot be reached ({one_line(error)})") from None
    with client:
        yield client


def fly_all(client: Client, runs: Sequence[PlannedRun], on_result: OnResult, on_drought: OnDrought) -> None:
    """
    Fly runs on a cluster, in their order as workers become free.

    Parameters
    ----------
    client : Client
        Connected to the cluster.
    runs : sequence of PlannedRun
        No key twice.
    on_result : callable
        Told each run and what came of it, as they end.
    on_drought : callable
        Told in words when there is no worker.

    Raises
    ------
    ClusterError
        When the scheduler is lost, or a worker cannot fly at all, for want of this project's source.

    """
    suspects = []
    for run, result in _fly(client, runs, "run", on_drought):
        if result is None:
            suspects.append(run)
        else:
            on_result(run, result)
    for run in suspects:
        ((_, result),) = _fly(client, [run], "run-alone", on_drought)
        on_result(run, result or _killed())


def _killed() -> Finished:
    line = "its worker process died every time; was there memory enough?"
    return Finished({}, line, line + "\n", is_lasting=False)


def _fly(
    client: Client, runs: Iterable[PlannedRun], word: str, on_drought: OnDrought
) -> Iterator[tuple[PlannedRun, Finished | None]]:
    """Yield runs and results, None where too many workers died; only so many are handed over at a time."""
    source, waiting = source_version(), iter(runs)
    flying: dict[Future, PlannedRun] = {}
    ended: SimpleQueue[Future] = SimpleQueue()

    def submit(count: int) -> None:
        for run in islice(waiting, count):
            # Keys of one group, so that Dask keeps what waits at the scheduler, not behind one worker's run.
            key = (f"{word}-{source}", run.key)
            future = client.submit(fly_run, run.scenario_json, source, key=key)
            flying[future] = run
            future.add_done_callback(ended.put)

    submit(max(_LEAST_SUBMITTED, _SUBMITTED_PER_THREAD * _n_threads(client)))
    while flying:
        future = _next(ended, client, on_drought)
        run, result = flying.pop(future), _result(future)
        future.release()
        submit(1)
        yield run, result


def _next(ended: SimpleQueue[Future], client: Client, on_drought: OnDrought) -> Future:
    """Return the next future that has ended, however long that takes."""
    looks = 0
    while True:
        try:
            return ended.get(timeout=_LOOK_EVERY_S)
        except Empty:
            if client.status != "running":
                raise ClusterError(_LOST) from None
            looks = 0 if _n_threads(client) else looks + 1
            if looks == _LOOKS_OF_A_DROUGHT:
                on_drought(f"waiting for a worker at {client.scheduler_info()['address']}")


def _n_threads(client: Client) -> int:
    """Return how many runs the workers can fly at once; raise ClusterError when the scheduler is silent."""
    try:
        return sum(client.nthreads(callback_timeout=_ANSWER_TIMEOUT_S).values())
    except (OSError, TimeoutError):
        raise ClusterError(f"the scheduler has not answered for {_ANSWER_TIMEOUT_S:g} s") from None


def _result(future: Future) -> Finished | None:
    try:
        finished: Finished = future.result()
    except KilledWorker:
        return None
    except CancelledError:
        raise ClusterError(_LOST) from None
    except SourceMismatchError as error:
        raise ClusterError(str(error)) from None
    except Exception as error:
        raise ClusterError(f"a worker cannot fly: {one_line(error)}") from None
    return finished
