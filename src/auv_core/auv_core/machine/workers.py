"""
Calls in worker processes that never outlive their parent, and that may be killed or stopped.

The workers are forked, so a call may be any function: it is inherited, and only its result is sent back.
Each worker has its own socket pair and shares no lock, so a worker that ends or stops in the middle of a
message does not block the others. A call whose worker ended is repeated by another worker. No process
listens, so no other program can send a call. Ctrl-C in a terminal reaches only the parent, which ends its
workers; if the parent is killed, the kernel kills them (PR_SET_PDEATHSIG, Linux). This module knows neither
runs nor figures.
"""

from __future__ import annotations

import ctypes
import math
import multiprocessing
import os
import signal
import socket
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from multiprocessing import connection
from typing import Any

from auv_core.machine.failure import Failure, WorkersError
from auv_core.machine.interrupts import SIGNALS
from auv_core.machine.worker_pipe import Inbox, send
from auv_core.machine.worker_watch import Watch

_WAIT_SLICE_S = 0.25
_LOOK_EVERY_S = 1.0
_LONGEST_LOOK_S = 2.0
"""
After a longer pause all processes were stopped, as by Ctrl-Z, and the time does not count against a call.
"""
_JOIN_TIMEOUT_S = 5.0
_TRIES_IN_COMPANY = 2
_STARTS_PER_WORKER = 3
_PR_SET_PDEATHSIG = 1
_INDEX_BYTES = 8
_KILLED = "its worker process died every time; was there memory enough?"

Advance = Callable[[float], None]
Call = Callable[[Advance], Any]


def spread(
    calls: Sequence[Call],
    n_workers: int,
    *,
    on_result: Callable[[int, Any], None],
    on_progress: Callable[[float], None] = lambda amount: None,
    on_message: Callable[[str], None] = lambda line: None,
    limit_s: Callable[[int], float] = lambda index: math.inf,
) -> None:
    """
    Make calls in worker processes, in their order as workers become free.

    Parameters
    ----------
    calls : sequence of callables
        Each gets a function `advance(amount)` that reports progress, and returns an object that can be
        pickled.
    n_workers : int
        Number of processes.
    on_result : callable
        Receives index and result of each call, or its `Failure`, when it ends; runs in this process.
    on_progress : callable
        Receives the sum of all amounts so far, from time to time.
    on_message : callable
        Receives one line if a worker no longer runs and is replaced.
    limit_s : callable
        Called repeatedly; returns how long the call of an index may take (s, wall).

    Raises
    ------
    WorkersError
        If every worker ends before it is ready, or no process can be started.

    Notes
    -----
    If the system cannot fork, the calls are made in this process, one after the other, without limits.
    A worker that is stopped, or that takes no processor time, is killed and replaced. A call whose worker
    ended twice is made once more, alone, so that only a call that kills its worker fails. A call that exceeds
    its limit is ended with its worker and fails. If an exception (Ctrl-C) ends the wait, the workers are
    killed and have ended when this returns.

    """
    if not hasattr(os, "fork"):
        _make_in_turn(calls, on_result, on_progress)
        return
    pool = _Pool(calls, on_result, on_progress, on_message, limit_s)
    try:
        pool.make(range(len(calls)), n_workers)
        for index in pool.take_suspects():
            pool.make([index], 1)
        for index in pool.take_suspects():
            on_result(index, Failure(_KILLED, _KILLED + "\n"))
    finally:
        pool.end()


def _make_in_turn(
    calls: Sequence[Call], on_result: Callable[[int, Any], None], on_progress: Callable[[float], None]
) -> None:
    done = 0.0

    def advance(amount: float) -> None:
        nonlocal done
        done += amount
        on_progress(done)

    for index, call in enumerate(calls):
        on_result(index, attempt(call, advance))


class _Worker:
    """A worker process, seen from its parent."""

    def __init__(self, calls: Sequence[Call]) -> None:
        self.stream, theirs = socket.socketpair()
        fork = multiprocessing.get_context("fork")
        self.process = fork.Process(target=_serve, args=(calls, theirs, os.getpid()), daemon=True)
        with theirs:
            _start(self.process)
        self.inbox = Inbox(self.stream)
        self.watch = Watch(self.process.pid)
        self.is_ready = False
        self.call: int | None = None
        self.amount = 0.0
        self.spent_s = 0.0

    @property
    def is_free(self) -> bool:
        """Whether it waits for a call."""
        return self.is_ready and self.call is None

    def give(self, index: int) -> None:
        """Start a call."""
        self.call, self.amount, self.spent_s = index, 0.0, 0.0
        with suppress(BrokenPipeError):  # it has just ended, and its sentinel shows that
            self.stream.send(index.to_bytes(_INDEX_BYTES, "little"))

    def end(self) -> None:
        """Kill it."""
        self.process.kill()
        self.process.join(_JOIN_TIMEOUT_S)
        self.stream.close()


class _Pool:
    """The workers and the waiting calls."""

    def __init__(
        self,
        calls: Sequence[Call],
        on_result: Callable[[int, Any], None],
        on_progress: Callable[[float], None],
        on_message: Callable[[str], None],
        limit_s: Callable[[int], float],
    ) -> None:
        self._calls = calls
        self._limit_s = limit_s
        self._on_result, self._on_progress, self._on_message = on_result, on_progress, on_message
        self._workers: list[_Worker] = []
        self._waiting: deque[int] = deque()
        self._deaths: Counter[int] = Counter()
        self._suspects: list[int] = []
        self._stillborn = 0
        self._done = 0.0
        self._looked_at_s = time.monotonic()

    def make(self, indices: Iterable[int], n_workers: int) -> None:
        """Make calls; a call whose workers ended too often becomes a suspect."""
        self._waiting.extend(indices)
        while busy := sum(worker.call is not None for worker in self._workers) + len(self._waiting):
            self._hire(min(n_workers, busy))
            for worker in self._workers:
                if worker.is_free and self._waiting:
                    worker.give(self._waiting.popleft())
            self._listen()
            self._look()
            self._on_progress(self._done + sum(worker.amount for worker in self._workers))

    def take_suspects(self) -> list[int]:
        """Return the calls that were given up since the last call of this method."""
        suspects, self._suspects = self._suspects, []
        return suspects

    def end(self) -> None:
        """Kill all workers and wait until they have ended."""
        for worker in self._workers:
            worker.process.kill()
        while self._workers:
            self._workers.pop().end()

    def _hire(self, count: int) -> None:
        while len(self._workers) < count:
            if self._stillborn >= _STARTS_PER_WORKER * count:
                raise WorkersError(f"all of {self._stillborn} worker processes ended while they started")
            try:
                self._workers.append(_Worker(self._calls))
            except OSError as error:
                if not self._workers:
                    raise WorkersError(f"no worker process can be started ({error.strerror})") from None
                return

    def _listen(self) -> None:
        """Wait briefly for messages of workers, and for workers that end."""
        by_source: dict[Any, _Worker] = {}
        for worker in self._workers:
            by_source[worker.stream] = by_source[worker.process.sentinel] = worker
        heard = connection.wait(list(by_source), _WAIT_SLICE_S)
        for worker in {id(by_source[source]): by_source[source] for source in heard}.values():
            has_ended = worker.process.sentinel in heard
            for message in worker.inbox.read():
                self._take(worker, message)
            if has_ended:
                self._bury(worker)

    def _take(self, worker: _Worker, message: Any) -> None:
        kind, value = message
        if kind == "ready":
            worker.is_ready, self._stillborn = True, 0
        elif kind == "advance":
            worker.amount += value
        elif worker.call is not None:
            index, worker.call = worker.call, None
            self._done, worker.amount = self._done + worker.amount, 0.0
            self._on_result(index, value)

    def _bury(self, worker: _Worker) -> None:
        self._workers.remove(worker)
        worker.end()
        if not worker.is_ready:
            self._stillborn += 1
        if worker.call is None:
            return
        self._deaths[worker.call] += 1
        if self._deaths[worker.call] < _TRIES_IN_COMPANY:
            self._waiting.append(worker.call)
        else:
            self._suspects.append(worker.call)

    def _look(self) -> None:
        """Kill workers that no longer run or take too long."""
        passed_s = time.monotonic() - self._looked_at_s
        if passed_s < _LOOK_EVERY_S:
            return
        self._looked_at_s += passed_s
        for worker in list(self._workers):
            worker.spent_s += min(passed_s, _LONGEST_LOOK_S)
            if worker.call is not None and worker.spent_s > self._limit_s(worker.call):
                self._give_up(worker, worker.call)
                continue
            if not worker.is_free and (fault := worker.watch.look()):
                self._on_message(f"worker process {worker.process.pid} {fault}; it is ended and replaced")
                worker.process.kill()

    def _give_up(self, worker: _Worker, index: int) -> None:
        """End a worker whose call takes too long, and the call with it."""
        self._workers.remove(worker)
        worker.end()
        self._done += worker.amount
        line = f"took longer than {self._limit_s(index):.3g} s, and was ended"
        self._on_result(index, Failure(line, line + "\n"))


def _start(process: multiprocessing.process.BaseProcess) -> None:
    """Fork; the child inherits that signals are blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(calls: Sequence[Call], stream: socket.socket, parent_pid: int) -> None:
    """Make one call after the other: the main loop of a worker."""
    _become_worker(parent_pid)
    send(stream, ("ready", None))

    def advance(amount: float) -> None:
        send(stream, ("advance", amount))

    while index := stream.recv(_INDEX_BYTES):
        result = attempt(calls[int.from_bytes(index, "little")], advance)
        try:
            send(stream, ("result", result))
        except Exception as error:  # it cannot be pickled
            send(stream, ("result", Failure.of(error)))


def _become_worker(parent_pid: int) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    if hasattr(libc, "prctl"):
        libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent_pid:  # the parent died before the line above
        os._exit(1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


def attempt(call: Call, advance: Advance) -> Any:
    """Make a call; return its result, or its `Failure`."""
    try:
        return call(advance)
    except Exception as error:
        return Failure.of(error)
