"""
Calls spread over worker processes that never outlive their parent.

The workers are forked, so a call may be anything: it is inherited, only its result is sent back. Ctrl-C in
a terminal reaches only the parent, which ends its workers; if the parent is killed, the kernel kills them
(PR_SET_PDEATHSIG, Linux). Nothing here knows runs or figures.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from auv_bringup.failures import Failure, one_line

_WAIT_SLICE_S = 0.25
_PR_SET_PDEATHSIG = 1
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_libc = ctypes.CDLL(None, use_errno=True)

Advance = Callable[[float], None]
Call = Callable[[Advance], Any]


def spread(
    calls: Sequence[Call],
    n_workers: int,
    *,
    on_result: Callable[[int, Any], None],
    on_progress: Callable[[float], None] = lambda amount: None,
) -> None:
    """
    Make calls in worker processes, in their order as workers become free.

    Parameters
    ----------
    calls : sequence of callables
        Each gets a function `advance(amount)` for telling progress, and returns what can be pickled.
    n_workers : int
        Number of processes.
    on_result : callable
        Told index and result of each call, or its `Failure`, as they end; runs in this process.
    on_progress : callable
        Told now and then the sum of all amounts so far.

    Notes
    -----
    When an exception (Ctrl-C) ends the wait, the workers are killed and gone when this returns.

    """
    if not calls:
        return
    context = multiprocessing.get_context("fork")
    total = context.Value("d", 0.0)
    others = set(multiprocessing.active_children())
    executor = ProcessPoolExecutor(
        min(n_workers, len(calls)), context, initializer=_become_worker, initargs=(calls, total, os.getpid())
    )
    try:
        futures = _submit(executor, len(calls))
        waiting = set(futures)
        while waiting:
            done, waiting = wait(waiting, timeout=_WAIT_SLICE_S, return_when=FIRST_COMPLETED)
            on_progress(total.value)
            for future in sorted(done, key=futures.__getitem__):
                on_result(futures[future], _result(future))
    except BaseException:
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        raise
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


def _submit(executor: ProcessPoolExecutor, count: int) -> dict[Future[Any], int]:
    """Hand over all calls; the first one forks the workers, which inherit that signals are blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        return {executor.submit(_call, index): index for index in range(count)}
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _result(future: Future[Any]) -> Any:
    try:
        return future.result()
    except BrokenProcessPool:
        line = "its worker process was killed; was there memory enough?"
    except Exception as error:  # a result that cannot be sent
        line = one_line(error)
    return Failure(line, line + "\n")


class _Worker:
    """What a worker inherits."""

    calls: Sequence[Call] = ()
    total: Any = None


def _become_worker(calls: Sequence[Call], total: Any, parent_pid: int) -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent_pid:  # the parent died before the line above
        os._exit(1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
    _Worker.calls, _Worker.total = calls, total


def _call(index: int) -> Any:
    return attempt(_Worker.calls[index], _advance)


def attempt(call: Call, advance: Advance) -> Any:
    """Make a call; return its result, or the `Failure` that it ended in."""
    try:
        return call(advance)
    except Exception as error:
        return Failure.of(error)


def _advance(amount: float) -> None:
    with _Worker.total.get_lock():
        _Worker.total.value += amount
