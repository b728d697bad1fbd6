"""
Runs on a Dask cluster: one of this machine's own processes, or one that exists.

Results come back through Dask, so no folder need be shared. A run whose worker dies is given to another one,
by Dask; what dies with every worker is flown once more when nothing else is, so that only the run that kills
its worker fails and not one that happened to wait behind it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, as_completed

from auv_bringup.failures import one_line
from auv_bringup.run_key import source_version
from auv_bringup.sweeps.plan import PlannedRun
from auv_bringup.sweeps.worker import Finished, SourceMismatchError, fly_run

ALLOWED_DEATHS = 3
_LEAST_SUBMITTED = 500
_SUBMITTED_PER_THREAD = 4
_CONNECT_TIMEOUT_S = 10
_HERE = "127.0.0.1"
_CONFIG = {
    "distributed.scheduler.allowed-failures": ALLOWED_DEATHS,
    "distributed.scheduler.worker-saturation": 1.0,
    # Nothing to look at on the ports that Dask keeps for its dashboard.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    # A worker holds no data between runs, so to pause it would never free anything.
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
}

OnResult = Callable[[PlannedRun, Finished], None]


class ClusterError(RuntimeError):
    """A cluster that cannot be reached or cannot fly; the message is one line."""


@contextmanager
def local_client(n_workers: int) -> Iterator[Client]:
    """Start `n_workers` processes that nothing beyond this machine can reach; they end with the context."""
    with (
        dask.config.set(_CONFIG),
        LocalCluster(
            n_workers=n_workers,
            threads_per_worker=1,
            processes=True,
            host=_HERE,
            dashboard_address=None,
            worker_dashboard_address=None,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


@contextmanager
def remote_client(scheduler: str) -> Iterator[Client]:
    """
    Connect to the scheduler at an address, or named by a scheduler file (*.json).

    Raises
    ------
    ClusterError
        When it cannot be reached.

    """
    where = {"scheduler_file": scheduler} if scheduler.endswith(".json") else {"address": scheduler}
    try:
        client = Client(**where, timeout=_CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(f"--scheduler {scheduler!r}: cannot be reached ({one_line(error)})") from None
    with client:
        yield client


def fly_all(client: Client, runs: Sequence[PlannedRun], on_result: OnResult) -> None:
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

    Raises
    ------
    ClusterError
        When the scheduler is lost, or a worker cannot fly at all, for want of this project's source.

    """
    suspects = [run for run, result in _fly(client, runs, "run") if not _tell(run, result, on_result)]
    for run in suspects:
        ((_, result),) = _fly(client, [run], "run-alone")
        _tell(run, result or _killed(), on_result)


def _tell(run: PlannedRun, result: Finished | None, on_result: OnResult) -> bool:
    if result is not None:
        on_result(run, result)
    return result is not None


def _killed() -> Finished:
    line = "its worker process died every time; was there memory enough?"
    return Finished({}, line, line + "\n", is_lasting=False)


def _fly(
    client: Client, runs: Iterable[PlannedRun], word: str
) -> Iterator[tuple[PlannedRun, Finished | None]]:
    """Yield runs and results, None where too many workers died; only so many are handed over at a time."""
    waiting = iter(runs)
    flying: dict[Future, PlannedRun] = {}
    source = source_version()

    def submit(count: int) -> list[Future]:
        # Keys of one group, so that Dask keeps what waits at the scheduler, not behind one worker's run.
        new = {
            client.submit(fly_run, run.scenario_json, source, key=(f"{word}-{source}", run.key)): run
            for run in islice(waiting, count)
        }
        flying.update(new)
        return list(new)

    n_threads = sum(client.nthreads().values())
    completed = as_completed(submit(max(_LEAST_SUBMITTED, _SUBMITTED_PER_THREAD * n_threads)))
    for future in completed:
        yield flying.pop(future), _result(future)
        future.release()
        completed.update(submit(1))


def _result(future: Future) -> Finished | None:
    try:
        finished: Finished = future.result()
    except KilledWorker:
        return None
    except CancelledError:
        raise ClusterError("the scheduler is gone; finished runs are kept") from None
    except SourceMismatchError as error:
        raise ClusterError(str(error)) from None
    except Exception as error:
        raise ClusterError(f"a worker cannot fly: {one_line(error)}") from None
    return finished
