"""The launcher's ear: a ROS node that hears how a run is, and looks for strangers on its topics."""

from __future__ import annotations

import time
from collections.abc import Sequence
from types import TracebackType
from typing import Any

from auv_bringup.launching.flight_status import Status
from auv_bringup.launching.layout import ProcessSpec
from auv_bringup.launching.node_start import adopt
from auv_core.machine.leaving import keep
from auv_ros.run_config import LAUNCHER_NODE, WallWatch
from auv_ros.run_identity import status_epoch_s
from auv_ros.steady_timer import NEVER_S, SteadyTimer

CLOCK_NODE = "/clock_node"
"""It lives in the process of the relay."""
_WAKE_S = 0.1
_LOOK_S = 1.0


class StatusListener:
    """
    A small ROS node that hears /flock/status; hidden from `ros2 node list` by its name.

    Parameters
    ----------
    environ : dict
        Environment of the nodes.
    processes : sequence of ProcessSpec
        Those of the run.

    Attributes
    ----------
    strangers : list of str
        Who else published on topics of the run so far, a line each.

    """

    def __init__(self, environ: dict[str, str], processes: Sequence[ProcessSpec]) -> None:
        self._environ = environ
        nodes = [node for process in processes for node in process.nodes]
        self._own_nodes = {node.name for node in nodes} | {CLOCK_NODE}
        self._vehicle_ids = sorted({node.vehicle_id for node in nodes if node.vehicle_id})
        self._heard: list[Status] = []
        self._wall = WallWatch(time.monotonic, time.time)
        self._looked_at_s = time.monotonic()
        self.strangers: list[str] = []

    def __enter__(self) -> StatusListener:
        adopt(self._environ)
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.logging import LoggingSeverity
        from rclpy.signals import SignalHandlerOptions

        from auv_msgs.msg import FlockStatus
        from auv_ros.hearing import Hearing
        from auv_ros.qos import EVERY_LATCHED
        from auv_ros.strangers import StrangerWatch

        self._context = rclpy.Context()
        rclpy.init(args=[], context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(
            LAUNCHER_NODE.strip("/"),
            context=self._context,
            enable_rosout=False,
            start_parameter_services=False,
        )
        # The client library's own line about a stranger: `new_strangers` says it in plain words.
        self._node.get_logger().set_level(LoggingSeverity.ERROR)
        self._hearing = Hearing(self._node)
        self._hearing.listen_decoded(FlockStatus, "/flock/status", self._hear, EVERY_LATCHED)
        self._watch = StrangerWatch(self._node, self._own_nodes, self._vehicle_ids)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._waker = SteadyTimer(self._node, _WAKE_S, lambda: None)
        return self

    def listen(self) -> list[Status]:
        """Wait for a status, at most `_WAKE_S`; return those that came, oldest first."""
        self._executor.spin_once(timeout_sec=NEVER_S)
        heard, self._heard = self._heard, []
        return heard

    def new_strangers(self, *, at_once: bool = False) -> list[str]:
        """
        Return a line for each new publisher on topics of the run that is not of the run.

        The graph is asked once a second, or `at_once`.
        """
        if not at_once and time.monotonic() - self._looked_at_s < _LOOK_S:
            return []
        self._looked_at_s = time.monotonic()
        words = [stranger.words for stranger in self._watch.look()]
        self.strangers += words
        return words

    def refused_writers(self) -> list[str]:
        """Return a line for each topic heard here of how many writers were refused, also unnamed ones."""
        return [f"{topic}: writers refused: {count}" for topic, count in self._hearing.refused.items()]

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._waker.cancel()
        if self._wall.warning():
            keep(self._executor, self._node, self._context)
            return
        self._executor.shutdown(timeout_sec=1.0)
        self._node.destroy_node()
        self._context.try_shutdown()

    def _hear(self, message: Any) -> None:
        self._heard.append(
            Status(
                state=message.state,
                time_s=message.time_s,
                duration_s=message.duration_s,
                epoch_s=status_epoch_s(message),
                waiting_for=tuple(message.waiting_for),
                lost_vehicles=tuple(message.lost_vehicles),
                detail=message.detail,
            )
        )
