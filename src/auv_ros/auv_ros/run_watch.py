"""Messages of a waiting node process, and its end together with its run."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.node import Node

from auv_core.cdr import text_bytes
from auv_msgs.msg import FlockStatus
from auv_ros.hearing import Hearing, decoded
from auv_ros.qos import EVERY_MESSAGE
from auv_ros.run_identity import RunPoint, follows, is_of_run, run_point
from auv_ros.steady_timer import SteadyTimer

_SAY_S = 5.0
_GRACE_S = 3.0
STATUS_TOPIC = "/flock/status"
_OVER = (FlockStatus.FINISHED, FlockStatus.ABORTED)
_OVER_BYTES = tuple(map(text_bytes, _OVER))


def say_waits(node: Node) -> None:
    """Log every few seconds what a node waits for: `waits_for()` of the node, unless it is empty."""

    def say() -> None:
        words = node.waits_for()
        if words:
            node.get_logger().info(f"waits for {words}")

    if hasattr(node, "waits_for"):
        SteadyTimer(node, _SAY_S, say)


class RunEnd:
    """
    Notices that the run of a process is over; after some time, when all nodes have noticed, the process may
    end.

    An end that is received before any other status belongs to an earlier run and is ignored. Once the run
    has begun, an end with another epoch or length, or one that comes too early, belongs to another run. The
    same holds for an end after which the run goes on. The process with the clock of the run accepts no other
    end.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self._nodes = nodes
        self._clocks = [node for node in nodes if _speaks_for_the_run(node)]
        self._has_run = False
        self._run: RunPoint | None = None
        self._doubts = False
        self._end_heard: tuple[RunPoint, float] | None = None
        Hearing(nodes[0]).listen(FlockStatus, STATUS_TOPIC, self._hear, EVERY_MESSAGE)

    def is_past(self) -> bool:
        """Return whether the process must end, and log it once."""
        if self._end_heard is None or time.monotonic() - self._end_heard[1] < _GRACE_S:
            return False
        self._nodes[0].get_logger().info("the run is over, so this process ends")
        return True

    @property
    def is_lost(self) -> bool:
        """Whether the run has ended, and not as planned."""
        return self._end_heard is not None and self._end_heard[0].state == FlockStatus.ABORTED

    def _hear(self, data: bytes) -> None:
        may_be_over = any(word in data for word in _OVER_BYTES)
        if not may_be_over and self._run is not None and self._end_heard is None:
            return  # the usual status of a run needs no action
        point = run_point(decoded(FlockStatus, data))
        is_over = point.state in _OVER
        self._has_run |= not is_over
        if self._run is None and point.state == FlockStatus.RUNNING:
            self._run = point
        if self._end_heard is not None and not is_over:
            self._go_on(self._end_heard[0], point)
        elif self._end_heard is None and is_over and self._has_run:
            self._end(point)

    def _end(self, point: RunPoint) -> None:
        is_foreign = self._run is not None and not follows(self._run, point)
        if is_foreign or not all(getattr(clock, "done", False) for clock in self._clocks):
            self._doubt(point)
            return
        self._end_heard = point, time.monotonic()
        for node in self._nodes:
            getattr(node, "on_run_end", _nothing)()

    def _go_on(self, end: RunPoint, point: RunPoint) -> None:
        if self._run is not None and is_of_run(self._run, point):
            self._end_heard = None
            self._doubt(end)

    def _doubt(self, end: RunPoint) -> None:
        if not self._doubts:
            self._doubts = True
            self._nodes[0].get_logger().warning(
                f"{STATUS_TOPIC} says {end.state} at {end.time_s:g} of {end.duration_s:g} s: "
                "another run publishes it; ignored"
            )


def _speaks_for_the_run(node: Node) -> bool:
    return any(publisher.topic_name == STATUS_TOPIC for publisher in node.publishers)


def _nothing() -> None:
    pass
