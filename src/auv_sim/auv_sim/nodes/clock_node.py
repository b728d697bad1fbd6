"""
ROS node of the run's time: `/clock` in lock-step, the run's status, and who has fallen silent.

It lives in the process of the relay, which tells it by a call, without a message, when a tick is done.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from auv_core.params import param
from auv_msgs.msg import FlockStatus, RecorderStatus
from auv_ros.hearing import Hearing
from auv_ros.joining import LOOK_S
from auv_ros.qos import EVERY_TICK, LATCHED
from auv_ros.run_config import LAUNCHER_NODE, TickClock, WallWatch
from auv_ros.run_watch import STATUS_TOPIC
from auv_ros.steady_timer import SteadyTimer
from auv_ros.topic import RECORDER, Topic
from auv_ros.wire import conversions as convert

_REPEAT_S = 0.5
_STATUS_TICKS = 20
_RECORDER_LEAD_TICKS = 200


@dataclass(frozen=True, kw_only=True)
class WatchConfig:
    """Length of the run, and how long silence is borne."""

    duration_ticks: int = param("length of the run (control periods)", minimum=1)
    on_vehicle_loss: str = param("when a vehicle falls silent", default="stop", choices=("stop", "continue"))
    answer_timeout_s: float = param(
        "silence after which a node counts as lost (s, wall)", default=3.0, above=0.0
    )
    start_timeout_s: float = param("the same before the first tick (s, wall)", default=60.0, above=0.0)
    launched: bool = param("whether a launcher must hear the status before the first tick", default=False)


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
        Number of vehicles; without any the run ends.
    followers : sequence of str
        Full names of the nodes that learn of the begin of a run by its status.
    recorded : bool
        Whether to stay near a recorder.
    awaited : callable
        Full names of the nodes that owe an answer.
    drop : callable
        Told to go on without what is awaited; returns the ids of the vehicles lost by it.
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
        self._watch = watch
        self._ticks = ticks
        self._fleet_size = fleet_size
        self._recorded = recorded
        self._awaited = awaited
        self._drop = drop
        self._state = FlockStatus.WAITING
        self._detail = ""
        self._tick = 0
        self._recorded_ticks = 0
        self._recorder_heard_at_s = math.inf
        self._lost: list[str] = []
        self._moved_at_s = time.monotonic()
        self.done = False
        """Whether the run has come to its end, good or bad, which is that of its process, too."""
        self.exit_code = 0
        self._wall = WallWatch(time.monotonic, time.time)
        recorder = [RECORDER] if recorded else []
        self.topics: list[Topic] = []
        """What must be heard before the run begins."""
        if ticks.lockstep:
            self._clock = Topic(self, Clock, "/clock", convert.clock_stencil().filled, heard_by=recorder)
            self.topics.append(self._clock)
        hearers = [LAUNCHER_NODE] if watch.launched else []
        if not ticks.started:
            hearers += [*recorder, *followers]
        self._status = Topic(self, FlockStatus, STATUS_TOPIC, heard_by=hearers, qos=LATCHED)
        if hearers:
            self.topics.append(self._status)
        self._said = FlockStatus()
        self._said_at_s = -math.inf
        static = TFMessage(transforms=[convert.map_to_map_ned()])
        Topic(self, TFMessage, "/tf_static", qos=LATCHED).publish(static)
        Hearing(self).listen_decoded(RecorderStatus, "/recorder/status", self._on_recorder, EVERY_TICK)
        self.on_room: Callable[[], None] = _nothing
        SteadyTimer(self, LOOK_S, self._look)

    @property
    def has_room(self) -> bool:
        """Whether the recorder is near enough for another tick; only lock-step could outrun it."""
        lead = self._tick - self._recorded_ticks
        return not self._recorded or not self._ticks.lockstep or lead <= _RECORDER_LEAD_TICKS

    def announce(self) -> None:
        """Say that the run begins: everybody then knows the stamp of tick 0."""
        self._state = FlockStatus.RUNNING
        self._publish()

    def begin_tick(self, tick: int) -> None:
        """Announce a tick; the last one ends the run."""
        self._tick = tick
        self._moved_at_s = time.monotonic()
        if self._ticks.lockstep:
            self._clock.publish(self._ticks.stamp_s(tick))
        if tick >= self._watch.duration_ticks:
            self._end(FlockStatus.FINISHED, "")
        elif self._state != FlockStatus.RUNNING or tick % _STATUS_TICKS == 0:
            self.announce()

    def _on_recorder(self, message: RecorderStatus) -> None:
        waiting = not self.has_room
        self._recorder_heard_at_s = time.monotonic()
        self._recorded_ticks = message.ticks
        if waiting and self.has_room:
            self.on_room()

    def _look(self) -> None:
        """Watch and speak. In lock-step only ticks and events bring news, so that equal runs say the same."""
        if not self.done:
            self._watch_silence()
        if warning := self._wall.warning():
            self.get_logger().warning(warning)
        if not self._ticks.lockstep or self._state == FlockStatus.WAITING:
            self._publish()
        elif time.monotonic() - self._said_at_s > _REPEAT_S:
            self._send(self._said)

    def _watch_silence(self) -> None:
        awaited = self._overdue()
        if not awaited:
            return
        words = f"{', '.join(awaited)}: no answer for tick {self._tick} within {self._limit_s:g} s"
        self.get_logger().error(words)
        self._state = FlockStatus.STALLED
        self._detail = words
        self._publish()
        if RECORDER in awaited or not self._started or self._watch.on_vehicle_loss == "stop":
            self.exit_code = 3
            self._end(FlockStatus.ABORTED, words)
            return
        self._moved_at_s = time.monotonic()
        self._state = FlockStatus.RUNNING
        self._lost += self._drop()
        if len(self._lost) == self._fleet_size:
            self.exit_code = 3
            self._end(FlockStatus.ABORTED, "every vehicle is lost")
        else:
            self._publish()
        self.on_room()

    @property
    def _started(self) -> bool:
        return self._tick > 0

    @property
    def _limit_s(self) -> float:
        return self._watch.answer_timeout_s if self._started else self._watch.start_timeout_s

    def _overdue(self) -> list[str]:
        """Return the full names of the nodes that have been silent for too long."""
        now_s = time.monotonic()
        if now_s - self._recorder_heard_at_s > self._limit_s:
            return [RECORDER]
        if (self._ticks.lockstep or not self._started) and now_s - self._moved_at_s < self._limit_s:
            return []
        return self._silent() or ([] if self._started else ["/acoustic_relay_node"])

    def _silent(self) -> list[str]:
        return self._awaited() if self.has_room else [RECORDER]

    def _end(self, state: str, detail: str) -> None:
        self._state = state
        self._detail = detail
        self.done = True
        self._publish()

    def _publish(self) -> None:
        running, waiting = self._state == FlockStatus.RUNNING, self._state == FlockStatus.WAITING
        self._send(
            FlockStatus(
                header=convert.header(0.0 if waiting else self._ticks.stamp_s(self._tick), ""),
                state=self._state,
                tick=self._tick,
                time_s=self._ticks.scenario_s(self._tick),
                duration_s=self._ticks.scenario_s(self._watch.duration_ticks),
                waiting_for=[] if running or self.done else self._silent(),
                lost_vehicles=self._lost,
                detail=self._detail,
            )
        )

    def _send(self, status: FlockStatus) -> None:
        self._said, self._said_at_s = status, time.monotonic()
        self._status.publish(status)


def _nothing() -> None:
    pass
