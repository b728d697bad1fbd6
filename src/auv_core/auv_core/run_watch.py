"""What a process of nodes says while it waits, and how it ends with its run."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.node import Node

from auv_core.hearing import Hearing, decoded
from auv_core.qos import LATCHED
from auv_core.steady_timer import SteadyTimer
from auv_msgs.msg import FlockStatus

_SAY_S = 5.0
_GRACE_S = 3.0
_MOST_NAMES = 10
_EPOCH_TOLERANCE_S = 1e-3
_OVER = (FlockStatus.FINISHED, FlockStatus.ABORTED)
_OVER_BYTES = tuple(state.encode() + b"\0" for state in _OVER)


def say_waits(node: Node) -> None:
    """Log every few seconds for what a node waits: `waits_for()` of the node, if it has any words."""

    def say() -> None:
        words = node.waits_for()
        if words:
            node.get_logger().info(f"waits for {words}")

    if hasattr(node, "waits_for"):
        SteadyTimer(node, _SAY_S, say)


def listed(names: Sequence[str]) -> str:
    """Return names for people, the first few of many."""
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more


class Standstill:
    """Tells whether something has not moved since it was looked at last, or since its start."""

    def __init__(self, start: int) -> None:
        self._last = start

    def at(self, progress: int) -> bool:
        """Return whether `progress` is what it was at the last call."""
        last, self._last = self._last, progress
        return last == progress


class RunEnd:
    """
    Hears that the run of a process is over; some time later, when everybody has heard it, it is past.

    What is heard before any other status is the end of an earlier run, and of no concern.  Once the run has
    begun, an end with another epoch or length, or that comes too early, is that of another run.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self._nodes = nodes
        self._has_run = False
        self._run: FlockStatus | None = None
        self._doubts = False
        self._over_at_s: float | None = None
        Hearing(nodes[0]).listen(FlockStatus, "/flock/status", self._hear, LATCHED)

    def is_past(self) -> bool:
        """Return whether the process shall end, and say so once it shall."""
        if self._over_at_s is None or time.monotonic() - self._over_at_s < _GRACE_S:
            return False
        self._nodes[0].get_logger().info("the run is over, so this process ends")
        return True

    def _hear(self, data: bytes) -> None:
        may_be_over = any(word in data for word in _OVER_BYTES)
        if not may_be_over and self._run is not None:
            return  # the usual status of a run: nothing of it is needed
        status = decoded(FlockStatus, data)
        is_over = status.state in _OVER
        self._has_run |= not is_over
        if not is_over and self._run is None:
            self._begin(status)
        elif is_over and self._has_run and self._over_at_s is None:
            self._end(status)

    def _begin(self, status: FlockStatus) -> None:
        if status.state == FlockStatus.RUNNING:
            self._run = status

    def _end(self, status: FlockStatus) -> None:
        if self._run is not None and not _is_end_of(self._run, status):
            if not self._doubts:
                self._doubts = True
                self._nodes[0].get_logger().warning(
                    f"/flock/status says {status.state} at {status.time_s:g} of {status.duration_s:g} s: "
                    "another run publishes it; not believed"
                )
            return
        self._over_at_s = time.monotonic()
        for node in self._nodes:
            getattr(node, "on_run_end", _nothing)()


def _is_end_of(run: FlockStatus, end: FlockStatus) -> bool:
    """Return whether an end is of the run that a status tells of: same epoch, same length, not before it."""
    is_same = (
        end.duration_s == run.duration_s
        and abs(status_epoch_s(end) - status_epoch_s(run)) < _EPOCH_TOLERANCE_S
    )
    is_reached = end.time_s >= run.time_s and (
        end.state != FlockStatus.FINISHED or end.time_s >= end.duration_s
    )
    return is_same and is_reached


def status_epoch_s(status: FlockStatus) -> float:
    """Return the stamp of scenario time 0 (s) of the run that a status tells of."""
    stamp = status.header.stamp
    return stamp.sec + 1e-9 * stamp.nanosec - status.time_s


def _nothing() -> None:
    pass
