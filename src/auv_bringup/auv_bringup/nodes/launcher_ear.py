"""
Process that listens to a run for its launcher: ``python -m auv_bringup.nodes.launcher_ear FILE_DESCRIPTOR``.

Its node's name hides it from `ros2 node list`. It ends when the launcher closes the connection; it ignores
signals that ask for an end.
"""

from __future__ import annotations

import signal
import sys
import time
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.signals import SignalHandlerOptions

from auv_bringup.launching.flight_status import Status
from auv_bringup.launching.node_start import adopt
from auv_bringup.launching.status_listener import News, Opening
from auv_msgs.msg import FlockStatus
from auv_ros.hearing import Hearing
from auv_ros.qos import EVERY_LATCHED
from auv_ros.run_config import LAUNCHER_NODE
from auv_ros.run_identity import status_epoch_s
from auv_ros.run_watch import STATUS_TOPIC
from auv_ros.steady_timer import NEVER_S, SteadyTimer
from auv_ros.strangers import StrangerWatch

_WAKE_S = 0.1
_LOOK_S = 1.0


class LauncherEar:
    """Receives /flock/status, and finds foreign publishers on topics of the run."""

    def __init__(self, opening: Opening) -> None:
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(
            LAUNCHER_NODE.strip("/"), enable_rosout=False, start_parameter_services=False
        )
        # The client library's own line about a foreign publisher: `look` reports it more clearly.
        self._node.get_logger().set_level(LoggingSeverity.ERROR)
        self._statuses: list[Status] = []
        self._hearing = Hearing(self._node)
        self._hearing.listen_decoded(FlockStatus, STATUS_TOPIC, self._hear, EVERY_LATCHED)
        self._watch = StrangerWatch(self._node, opening.own_nodes, opening.vehicle_ids)
        self._looked_at_s = time.monotonic()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._waker = SteadyTimer(self._node, _WAKE_S, lambda: None)

    def listen(self) -> News:
        """Wait for a status, at most `_WAKE_S`; return the news."""
        self._executor.spin_once(timeout_sec=NEVER_S)
        is_time = time.monotonic() - self._looked_at_s > _LOOK_S
        return self.look() if is_time else self._news()

    def look(self, *, is_answer: bool = False) -> News:
        """Look for foreign publishers; return the news."""
        self._looked_at_s = time.monotonic()
        strangers = tuple(stranger.words for stranger in self._watch.look())
        return self._news()._replace(strangers=strangers, is_answer=is_answer)

    def close(self) -> None:
        """Leave the graph."""
        self._waker.cancel()
        self._executor.shutdown(timeout_sec=1.0)
        self._node.destroy_node()
        rclpy.try_shutdown()

    def _news(self) -> News:
        statuses, self._statuses = tuple(self._statuses), []
        refused = [f"{topic}: writers refused: {count}" for topic, count in self._hearing.refused.items()]
        return News(statuses, refused=tuple(refused))

    def _hear(self, message: Any) -> None:
        self._statuses.append(
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


def serve(line: Connection) -> int:
    """Listen to a run until the connection ends; return the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    opening: Opening = line.recv()
    adopt(opening.environ)
    ear = LauncherEar(opening)
    with suppress(EOFError, ConnectionError):
        said = News()
        while True:
            news = ear.listen()
            if news.statuses or news.strangers or news.refused != said.refused:
                line.send(news)
                said = news
            if line.poll():
                line.recv()
                line.send(ear.look(is_answer=True))
    ear.close()
    return 0


def main() -> None:
    """Listen to a run for the launcher at the other end of the connection."""
    raise SystemExit(serve(Connection(int(sys.argv[1]))))


if __name__ == "__main__":
    main()
