"""
Timers of nodes on the steady clock, in the executor's thread.

The timers and time-outs of rclpy and of the middleware are on the steady clock too, but the wheels are built
for a C library that cannot wait on it: they wait until a time of the system clock instead, and where that one
is stepped back by an hour, a timer is late by an hour.  Python waits on the steady clock itself.  So one
thread of the process waits, and hands what is due to the executors, which wakes them, too.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

_LONGEST_NAP_S = 0.05


class SteadyTimer:
    """
    Calls a function of a node in every period, until cancelled.

    Where the executor is busy for longer than a period, calls are left out. An exception ends the timer and
    becomes the `timer_error` of the node.

    Parameters
    ----------
    node : rclpy.node.Node
        Nothing is called before it has an executor.
    period_s : float
        Time between two calls (s).
    callback : callable
        Called without arguments, in the thread of the executor.
    first_in_s : float, optional
        Time until the first call (s); a period without it.

    """

    def __init__(
        self, node: Any, period_s: float, callback: Callable[[], None], first_in_s: float | None = None
    ) -> None:
        self._node = node
        self._period_s = period_s
        self._callback = callback
        self._is_handed_over = False
        self.due_s = time.monotonic() + (period_s if first_in_s is None else first_in_s)
        _ticker.add(self)

    def cancel(self) -> None:
        """Call no more: once this returns, nothing is handed over."""
        _ticker.remove(self)

    def hand_over(self, now_s: float) -> None:
        """Give the call that is due to the executor, where the last one is done."""
        self.due_s = max(self.due_s + self._period_s, now_s)
        executor = self._node.executor
        if executor is not None and not self._is_handed_over:
            self._is_handed_over = True
            executor.create_task(self._call)

    def _call(self) -> None:
        self._is_handed_over = False
        try:
            self._callback()
        except Exception as error:  # an executor of events does not survive it
            self._node.timer_error = error
            self.cancel()


class _Ticker:
    """The thread that waits for all timers of the process; there is none as long as there is no timer."""

    def __init__(self) -> None:
        self._timers: set[SteadyTimer] = set()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def add(self, timer: SteadyTimer) -> None:
        with self._lock:
            self._timers.add(timer)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="steady timers", daemon=True)
                self._thread.start()

    def remove(self, timer: SteadyTimer) -> None:
        with self._lock:
            self._timers.discard(timer)

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._timers:
                    self._thread = None
                    return
                now_s = time.monotonic()
                for timer in self._timers:
                    if timer.due_s <= now_s:
                        timer.hand_over(now_s)
                due_s = min(timer.due_s for timer in self._timers)
            time.sleep(min(max(due_s - time.monotonic(), 0.0), _LONGEST_NAP_S))


_ticker = _Ticker()
