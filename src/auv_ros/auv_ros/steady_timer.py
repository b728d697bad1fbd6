"""
Timers of nodes on the steady clock, in the executor's thread.

The timers and time-outs of rclpy and of the middleware also use the steady clock, but the wheels are built
for a C library that cannot wait on it. They wait for a time of the system clock instead: if that clock is
stepped back by an hour, a timer is late by an hour. Python itself waits on the steady clock. So one thread of
the process waits, and passes due calls to the executors, which also wakes them.

Two threads share Python's lock. A thread that waits for it is woken in vain each time the other one leaves
Python for a moment, forty times per millisecond in a fast flight, until the switch interval is over:
`main_loop` makes this interval short.
"""

from __future__ import annotations

import math
import os
import select
import threading
import time
from collections.abc import Callable
from typing import Any

NEVER_S = 1e6
"""Time-out of an executor that these timers wake; without a time-out the executor of the wheels is busy."""


class SteadyTimer:
    """
    Calls a function of a node once per period, until cancelled.

    If the executor is busy for longer than a period, calls are skipped. An exception ends the timer and
    becomes the `timer_error` of the node.

    Parameters
    ----------
    node : rclpy.node.Node
        No call is made before it has an executor.
    period_s : float
        Time between two calls (s).
    callback : callable
        Called without arguments, in the thread of the executor.
    first_in_s : float, optional
        Time until the first call (s); by default one period.

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
        """Cancel: after this returns no more calls are passed on."""
        _ticker.remove(self)

    def hand_over(self, now_s: float) -> None:
        """Pass the due call to the executor, if the last call is done."""
        self.due_s = max(self.due_s + self._period_s, now_s)
        executor = self._node.executor
        if executor is not None and not self._is_handed_over:
            self._is_handed_over = True
            executor.create_task(self._call)

    def _call(self) -> None:
        self._is_handed_over = False
        try:
            self._callback()
        except Exception as error:  # an EventsExecutor does not survive it
            self._node.timer_error = error
            self.cancel()


class _Ticker:
    """The thread that waits for all timers of the process; it exists only while there are timers."""

    def __init__(self) -> None:
        self._timers: set[SteadyTimer] = set()
        self._lock = threading.Lock()
        self._bell: _Bell | None = None
        self._wakes_s = math.inf

    def add(self, timer: SteadyTimer) -> None:
        with self._lock:
            self._timers.add(timer)
            if self._bell is None:
                self._bell = _Bell()
                threading.Thread(target=self._run, args=[self._bell], daemon=True).start()
            elif timer.due_s < self._wakes_s:
                self._bell.ring()

    def remove(self, timer: SteadyTimer) -> None:
        with self._lock:
            self._timers.discard(timer)
            if self._bell is not None and not self._timers:
                self._bell.ring()

    def _run(self, bell: _Bell) -> None:
        while True:
            with self._lock:
                if not self._timers:
                    self._bell = None
                    bell.close()
                    return
                now_s = time.monotonic()
                for timer in self._timers:
                    if timer.due_s <= now_s:
                        timer.hand_over(now_s)
                self._wakes_s = min(timer.due_s for timer in self._timers)
            bell.wait_until(self._wakes_s)


class _Bell:
    """Wakes the waiting thread, which would otherwise have to check for new timers many times a second."""

    def __init__(self) -> None:
        self._heard, self._rung = os.pipe()
        self._poll = select.poll()
        self._poll.register(self._heard, select.POLLIN)

    def ring(self) -> None:
        os.write(self._rung, b"!")

    def wait_until(self, time_s: float) -> None:
        """Wait for a ring, at most until a time of the steady clock (s); poll has a resolution of 1 ms."""
        left_s = time_s - time.monotonic()
        if left_s > 0.0 and self._poll.poll(int(left_s * 1e3)):
            os.read(self._heard, 4096)
        elif (left_s := time_s - time.monotonic()) > 0.0:
            time.sleep(left_s)

    def close(self) -> None:
        os.close(self._heard)
        os.close(self._rung)


_ticker = _Ticker()
