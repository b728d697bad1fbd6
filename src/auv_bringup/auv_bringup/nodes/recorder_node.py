"""
Node that records every topic of the graph into a rosbag2 bag, without deserialising anything.

Messages wait in the middleware until the recorder takes many at once, topic by topic: at every so many ticks
of `/clock`, and once a second.  Taken one by one, each as an event of its own, they would cost several times
as much processor time, which in lock-step is the flight's.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.time import Time

from auv_bringup.bag_recorder import BagRecorder
from auv_bringup.bag_writer import BagError, BagWriter, Qos
from auv_bringup.message_definitions import DefinitionError
from auv_bringup.recorded_topics import CLOCK_TOPIC, topics_of_graph
from auv_bringup.ros_types import message_class, qos_of_profile
from auv_core.node_main import LATCHED, main_loop, steady_timer
from auv_core.node_params import declare_config
from auv_core.params import ConfigError, param
from auv_msgs.msg import RecorderStatus

EXIT_INTERNAL = 1
TICKS_PER_BATCH = 20
CHECKPOINT_PERIOD_S = 1.0
QUIET_BEFORE_CLOSE_S = 0.3
DRAIN_LIMIT_S = 20.0


@dataclass(frozen=True, kw_only=True)
class RecorderConfig:
    """What to record, and where to."""

    bag_dir: str = param("folder of the bag; it must not exist yet")
    topics_vehicles: tuple[str, ...] = param("ids of the vehicles whose topics are recorded")
    kinematic: bool = param("whether the vehicles take cmd_vel instead of cmd_wrench", default=False)


class RecorderNode(Node):
    """Records until it is told to stop, then takes what has already arrived and closes the bag."""

    def __init__(self, **options: Any) -> None:
        super().__init__("recorder_node", **options)
        self.done = False
        self.exit_code = 0
        config = declare_config(self, RecorderConfig)
        self._bag_dir = Path(config.bag_dir)
        self._status = self.create_publisher(RecorderStatus, "/recorder/status", LATCHED)
        self._takers: list[tuple[Subscription, Callable[[Sequence[bytes]], None]]] = []
        self._clock: Subscription | None = None
        self._heard_ticks: list[bytes] = []
        try:
            self._writer = BagWriter(self._bag_dir)
            self._recorder = BagRecorder(self._writer, self._offered_qos)
            self._subscribe(config)
        except (BagError, DefinitionError) as error:
            raise ConfigError(str(error)) from None
        steady_timer(self, CHECKPOINT_PERIOD_S, self._checkpoint)
        self._publish_status()

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """The subscriptions that the executor shall serve: that of the clock."""
        if self._clock is not None:
            yield self._clock

    def on_stop(self) -> None:
        """Record what has arrived, close the bag, say so."""
        self._drain()
        if self.done:
            return
        self._guarded(self._recorder.finish)
        if not self.done:
            self._publish_status(closed=True)

    def _subscribe(self, config: RecorderConfig) -> None:
        """Subscribe to everything, raw; of all topics the executor serves the clock's only."""
        for spec in topics_of_graph(config.topics_vehicles, kinematic=config.kinematic):
            kind, qos = message_class(spec.type_name), _keep_all(latched=spec.latched)
            subscription = self.create_subscription(kind, spec.name, self._hear_clock, qos, raw=True)
            if spec.name == CLOCK_TOPIC:
                self._clock = subscription
            self._takers.append((subscription, self._recorder.sink(spec)))

    def _hear_clock(self, data: bytes) -> None:
        """Keep a tick, and now and then record everything, saying how far the recorder is."""
        self._heard_ticks.append(data)
        if len(self._heard_ticks) >= TICKS_PER_BATCH:
            self._record()
            self._publish_status()

    def _checkpoint(self) -> None:
        """Take everything and bring the files up to date."""
        self._record()
        self._guarded(self._writer.checkpoint)
        self._publish_status()

    def _record(self) -> int:
        """Take all messages that wait; return how many."""
        count = 0
        for subscription, take in self._takers:
            messages = _waiting(subscription)
            if subscription is self._clock:
                messages = self._heard_ticks + messages
                self._heard_ticks = []
            take(messages)
            count += len(messages)
        self._guarded(self._recorder.flush)
        return count

    def _guarded(self, write: Callable[[], None]) -> None:
        """Write; where that cannot be, end the recording with one error."""
        if self.done:
            return
        try:
            write()
        except OSError as error:
            self._fail(error)

    def _drain(self) -> None:
        """Take messages until none has come for a while: some may still be on their way."""
        limit = time.monotonic() + DRAIN_LIMIT_S
        quiet_at = time.monotonic() + QUIET_BEFORE_CLOSE_S
        pause = threading.Event()
        while time.monotonic() < min(quiet_at, limit) and not self.done:
            if self._record():
                quiet_at = time.monotonic() + QUIET_BEFORE_CLOSE_S
            else:
                pause.wait(0.01)

    def _offered_qos(self, topic: str) -> tuple[Qos, ...]:
        """Return what the publishers of a topic offer."""
        return tuple(qos_of_profile(each.qos_profile) for each in self.get_publishers_info_by_topic(topic))

    def _publish_status(self, *, closed: bool = False) -> None:
        status = RecorderStatus(
            ticks=self._recorder.ticks,
            messages=self._writer.message_count,
            bytes=self._writer.byte_count,
            closed=closed,
        )
        status.header.stamp = Time(nanoseconds=self._recorder.now_ns).to_msg()
        self._status.publish(status)

    def _fail(self, error: OSError) -> None:
        """End the recording with one error: what is in the file stays readable."""
        self.get_logger().error(f"cannot write the bag {self._bag_dir}: {error.strerror}")
        self.exit_code = EXIT_INTERNAL
        self.done = True
        self._writer.abandon()


def _waiting(subscription: Subscription) -> list[bytes]:
    """Take every message that waits in a subscription."""
    handle = subscription.handle
    with handle:
        take = partial(handle.take_message, subscription.msg_type, True)
        return [data for data, _ in iter(take, None)]


def _keep_all(*, latched: bool) -> QoSProfile:
    """Return a reliable profile that drops nothing."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return the node; `options` are those of `rclpy.node.Node`."""
    return [RecorderNode(**options)]


def main() -> None:
    """Record until stopped."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
