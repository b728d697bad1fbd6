"""
Runs on an existing Dask cluster.

Results come back through Dask, so no shared folder is needed. If a worker dies, Dask gives its runs to
another one. Runs that lose every worker are flown once more, each alone, so that only the run that kills its
worker fails, and not the runs that waited behind it.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from distributed import Client, Future, KilledWorker
from distributed.comm import get_address_host_port

from auv_core.machine.failure import WorkersError, one_line
from auv_core.params import ConfigError
from auv_experiment.run_key import source_version
from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.worker import Finished, SourceMismatchError, fly_run

_LEAST_SUBMITTED = 500
_SUBMITTED_PER_THREAD = 4
_CONNECT_TIMEOUT_S = 10
_LOOK_EVERY_S = 5.0
_LOOKS_OF_A_DROUGHT = 3
_LOOKS_OF_SILENCE = 6
_ANSWER_TIMEOUT_S = 30.0

_UNREACHABLE = (OSError, ValueError, LookupError, TypeError, RuntimeError)
"""Exceptions of Dask; TypeError for a tls:// address if no certificate is configured."""
_LOST = "the scheduler is gone"

OnResult = Callable[[PlannedRun, Finished], None]
OnMessage = Callable[[str], None]


class ClusterError(WorkersError):
    """Raised if the cluster is lost or cannot fly; the message is one line."""


def fly_there(
    runs: Sequence[PlannedRun], on_result: OnResult, on_message: OnMessage, *, scheduler: str
) -> None:
    """
    Fly runs on the Dask cluster of a scheduler; see `remote_client` and `fly_with`.

    Raises
    ------
    ConfigError, ClusterError
        As these two functions raise them.

    """
    with remote_client(scheduler) as client:
        fly_with(client, runs, on_result, on_message)


@contextmanager
def remote_client(scheduler: str) -> Iterator[Client]:
    """
    Connect to the scheduler at an address, or named by a scheduler file (*.json).

    Raises
    ------
    ConfigError
        If it cannot be reached.

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


def fly_with(client: Client, runs: Sequence[PlannedRun], on_result: OnResult, on_message: OnMessage) -> None:
    """
    Fly runs on a cluster, in their order as workers become free.

    Parameters
    ----------
    client : Client
        Client that is connected to the cluster.
    runs : sequence of PlannedRun
        Runs with different keys.
    on_result : callable
        Receives each run and its outcome when it ends.
    on_message : callable
        Receives one line if there is no worker, or if one is silent.

    Raises
    ------
    ClusterError
        If the scheduler is lost or silent, or a worker has other source and cannot fly.

    """
    suspects = []
    for run, result in _fly(client, runs, "run", on_message):
        if result is None:
            suspects.append(run)
        else:
            on_result(run, result)
    for run in suspects:
        ((_, result),) = _fly(client, [run], "run-alone", on_message)
        on_result(run, result or _killed())


def _killed() -> Finished:
    line = "its worker process died every time; was there memory enough?"
    return Finished({}, line, line + "\n", is_lasting=False)


def _fly(
    client: Client, runs: Iterable[PlannedRun], word: str, on_message: OnMessage
) -> Iterator[tuple[PlannedRun, Finished | None]]:
    """Yield runs and results, None if too many workers died; a limited number is handed over at a time."""
    source, waiting = source_version(), iter(runs)
    flying: dict[Future, PlannedRun] = {}
    ended: SimpleQueue[Future] = SimpleQueue()
    watch = _Watch(client, on_message)

    def submit(count: int) -> None:
        for run in islice(waiting, count):
            # Keys of one group, so that Dask keeps waiting runs at the scheduler and not behind one worker's
            # run.
            key = (f"{word}-{source}", run.key)
            future = client.submit(fly_run, run.scenario_json, source, key=key)
            flying[future] = run
            future.add_done_callback(ended.put)

    submit(max(_LEAST_SUBMITTED, _SUBMITTED_PER_THREAD * _identity(client)["total_threads"]))
    while flying:
        future = _next(ended, watch)
        run, result = flying.pop(future), _result(future)
        future.release()
        submit(1)
        yield run, result


def _next(ended: SimpleQueue[Future], watch: _Watch) -> Future:
    """Return the next future that ends; wait without limit."""
    while True:
        try:
            return ended.get(timeout=_LOOK_EVERY_S)
        except Empty:
            watch.look()


class _Watch:
    """Watches a cluster while no run ends, and reports the cause of the wait."""

    def __init__(self, client: Client, on_message: OnMessage) -> None:
        self._client, self._on_message = client, on_message
        self._looks_of_drought = 0
        self._silent_looks: Counter[tuple[str, float]] = Counter()

    def look(self) -> None:
        """Name silent workers; raise ClusterError if the scheduler is lost."""
        if self._client.status != "running":
            raise ClusterError(_LOST)
        identity = _identity(self._client)
        self._looks_of_drought = 0 if identity["workers"] else self._looks_of_drought + 1
        if self._looks_of_drought == _LOOKS_OF_A_DROUGHT:
            self._on_message(f"waiting for a worker at {identity['address']}")
        heard = [(address, worker["last_seen"]) for address, worker in identity["workers"].items()]
        self._silent_looks = Counter({sign: self._silent_looks[sign] + 1 for sign in heard})
        for (address, _), looks in self._silent_looks.items():
            if looks == _LOOKS_OF_SILENCE:
                self._on_message(
                    f"worker {address} is silent; the scheduler gives its runs to others after its worker-ttl"
                )


def _identity(client: Client) -> dict[str, Any]:
    """Return the scheduler's description of itself and its workers; raise ClusterError if it is silent."""
    try:
        identity: dict[str, Any] = client.sync(
            client.scheduler.identity, n_workers=-1, callback_timeout=_ANSWER_TIMEOUT_S
        )
    except TimeoutError:
        raise ClusterError(_silent()) from None
    except OSError:
        raise ClusterError(_LOST) from None
    return identity


def _silent() -> str:
    return f"the scheduler has not answered for {_ANSWER_TIMEOUT_S:g} s"


def _result(future: Future) -> Finished | None:
    try:
        finished: Finished = future.result(timeout=_ANSWER_TIMEOUT_S)
    except KilledWorker:
        return None
    except TimeoutError:
        raise ClusterError(_silent()) from None
    except (CancelledError, OSError):  # fly_run raises none of its own
        raise ClusterError(_LOST) from None
    except SourceMismatchError as error:
        raise ClusterError(str(error)) from None
    except Exception as error:
        raise ClusterError(f"a worker cannot fly: {one_line(error)}") from None
    return finished
