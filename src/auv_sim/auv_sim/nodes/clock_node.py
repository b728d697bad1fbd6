"""
ROS node of the run's time: `/clock` in lock-step, the run's status, and the detection of silent nodes.

It runs in the process of the relay, which calls it directly, without a message, when a tick is done.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from auv_msgs.msg import FlockStatus, RecorderStatus
from auv_ros.hearing import Hearing
from auv_ros.joining import LOOK_S
from auv_ros.qos import EVERY_TICK, LATCHED, LATCHED_SERIES
from auv_ros.run_config import LAUNCHER_NODE, TickClock, WallWatch
from auv_ros.run_watch import STATUS_TOPIC
from auv_ros.steady_timer import SteadyTimer
from auv_ros.topic import RECORDER, Topic
from auv_ros.wire import conversions as convert
from auv_sim.run_state import RUNNING, WAITING, RunState, WatchConfig

_REPEAT_S = 0.5


class ClockNode(Node):
    """
    Publishes the run's time and status.

    Parameters
    ----------
    watch : WatchConfig
        Length of the run and time-outs.
    ticks : TickClock
        Stamps of ticks.
    fleet_size : int
        Number of vehicles; the run ends when none is left.
    followers : sequence of str
        Full names of the nodes that start when the status tells that the run begins.
    recorded : bool
        Whether to wait for a slow recorder.
    awaited : callable
        Returns the full names of the nodes that have not answered.
    drop : callable
        Continues without the awaited nodes; returns the ids of the vehicles that are lost.
    options
        Those of `rclpy.node.Node`.

    """

    def __init__(
        self,
        watch: WatchConfig,
        ticks: TickClock,
        *,
        fleet_size: int,
        followers: Sequence[str],
        recorded: bool,
        awaited: Callable[[], list[str]],
        drop: Callable[[], list[str]],
        **options: Any,
    ) -> None:
        super().__init__("clock_node", **options)
        self._ticks = ticks
        self._fleet_size = fleet_size
        self._awaited = awaited
        self._drop = drop
        self._duration_s = ticks.scenario_s(watch.duration_ticks)
        recorder = [RECORDER] if recorded else []
        self._run = RunState(
            watch, lockstep=ticks.lockstep, recorder=RECORDER if recorded else "", now_s=time.monotonic()
        )
        self._wall = WallWatch(time.monotonic, time.time)
        self.topics: list[Topic] = []
        """Topics that must be matched before the run begins."""
        if ticks.lockstep:
            self._clock = Topic(self, Clock, "/clock", convert.clock_stencil().filled, heard_by=recorder)
            self.topics.append(self._clock)
        hearers = [LAUNCHER_NODE] if watch.launched else []
        if not ticks.started:
            hearers += [*recorder, *followers]
        self._status = Topic(self, FlockStatus, STATUS_TOPIC, heard_by=hearers, qos=LATCHED_SERIES)
        if hearers:
            self.topics.append(self._status)
        self._said = FlockStatus()
        self._said_at_s = -math.inf
        static = TFMessage(transforms=[convert.map_to_map_ned()])
        Topic(self, TFMessage, "/tf_static", qos=LATCHED).publish(static)
        Hearing(self).listen_decoded(RecorderStatus, "/recorder/status", self._on_recorder, EVERY_TICK)
        self.on_room: Callable[[], object] = _nothing
        SteadyTimer(self, LOOK_S, self._look)

    @property
    def done(self) -> bool:
        """Whether the run has ended, in success or failure; the process then ends, too."""
        return self._run.done

    @property
    def exit_code(self) -> int:
        """Exit status of the process."""
        return self._run.exit_code

    @property
    def has_room(self) -> bool:
        """Whether the recorder is near enough for another tick."""
        return self._run.has_room

    def announce(self) -> None:
        """Publish that the run begins: all nodes then know the stamp of tick 0."""
        self._run.state = RUNNING
        self._publish()

    def begin_tick(self, tick: int) -> None:
        """Announce a tick; the last one ends the run."""
        is_news = self._run.begin_tick(tick, time.monotonic())
        if self._ticks.lockstep:
            self._clock.publish(self._ticks.stamp_s(tick))
        if is_news:
            self._publish()

    def _on_recorder(self, message: RecorderStatus) -> None:
        if self._run.hear_recorder(message.ticks, time.monotonic()):
            self.on_room()

    def _look(self) -> None:
        """
        Watch the nodes and publish the status. In lock-step only ticks and events change it, so that equal
        runs publish equal messages.
        """
        if not self.done:
            self._watch_silence()
        if warning := self._wall.warning():
            self.get_logger().warning(warning)
        if not self._ticks.lockstep or self._run.state == WAITING:
            self._publish()
        elif time.monotonic() - self._said_at_s > _REPEAT_S:
            self._send(self._said)

    def _watch_silence(self) -> None:
        overdue = self._run.overdue(self._awaited, time.monotonic())
        if not overdue:
            return
        self.get_logger().error(self._run.stall(overdue))
        self._publish()
        if not self._run.goes_on_without(overdue):
            self._publish()
            return
        self._run.lose(self._drop(), self._fleet_size, time.monotonic())
        self._publish()
        self.on_room()

    def _publish(self) -> None:
        run = self._run
        self._send(
            FlockStatus(
                header=convert.header(0.0 if run.state == WAITING else self._ticks.stamp_s(run.tick), ""),
                state=run.state,
                tick=run.tick,
                time_s=self._ticks.scenario_s(run.tick),
                duration_s=self._duration_s,
                waiting_for=[] if run.state == RUNNING or run.done else run.silent(self._awaited),
                lost_vehicles=run.lost,
                detail=run.detail,
            )
        )

    def _send(self, status: FlockStatus) -> None:
        self._said, self._said_at_s = status, time.monotonic()
        self._status.publish(status)


def _nothing() -> None:
    pass
