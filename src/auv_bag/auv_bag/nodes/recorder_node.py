"""
Node that records every topic of the graph into a rosbag2 bag without deserialising messages.

Messages wait in the middleware until the recorder takes many at once, topic by topic: once every few ticks
of `/clock`, and once a second. One event per message would take several times as much processor time, which
in lock-step delays the flight. A separate process writes the raw messages, and closes the bag even if this
one is killed (:mod:`auv_bag.process`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import HistoryPolicy
from rclpy.subscription import Subscription
from rclpy.time import Time

from auv_bag.collector import Collector
from auv_bag.link import BagLink
from auv_bag.recorder_config import RecorderConfig
from auv_bag.ros_types import message_class
from auv_bag.topic_spec import TopicSpec
from auv_bag.topics import CLOCK_TOPIC, LOG_TOPIC, RECORDER_TOPIC
from auv_bag.writer import BagError
from auv_core.params import ConfigError
from auv_core.words import listed
from auv_msgs.msg import RecorderStatus
from auv_ros.lifecycle import main_loop
from auv_ros.parameters import declare_config, refuse_unknown_parameters
from auv_ros.qos import LATCHED, own_qos
from auv_ros.steady_timer import SteadyTimer
from auv_ros.wire.log import logger_of

EXIT_INTERNAL = 1
CHECKPOINT_PERIOD_S = 1.0
QUIET_BEFORE_CLOSE_S = 0.3
DRAIN_LIMIT_S = 20.0


class RecorderNode(Node):
    """Records until it must stop, then takes all messages that have arrived and closes the bag."""

    def __init__(self, **options: Any) -> None:
        super().__init__("recorder_node", **options)
        self.done = False
        self.exit_code = 0
        self._config = declare_config(self, RecorderConfig)
        refuse_unknown_parameters([self])
        self._status = self.create_publisher(RecorderStatus, RECORDER_TOPIC.name, LATCHED)
        opening = self._config.opening
        self._bag = BagLink(opening)
        self._by_topic = {spec.name: self._subscription(spec) for spec in opening.topics}
        self._collector = Collector({topic: self._taker(topic) for topic in self._by_topic})
        try:
            self._bag.wait_until_open()
        except BagError as error:
            raise ConfigError(str(error)) from None
        SteadyTimer(self, CHECKPOINT_PERIOD_S, self._checkpoint)
        self._publish_status()

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """The subscriptions that the executor must serve: the clock, and topics that are not recorded."""
        recorded = {id(each) for topic, each in self._by_topic.items() if topic != CLOCK_TOPIC}
        yield from (each for each in super().subscriptions if id(each) not in recorded)

    def waits_for(self) -> str:
        """Return as text what the node waits for, or an empty text."""
        met, vehicles = self._collector.topics_met, self._config.topics_vehicles
        return listed([f"/{name}/vehicle_node" for name in vehicles if f"/{name}/state" not in met])

    def on_stop(self) -> None:
        """Record all messages that have arrived, close the bag, and publish the status."""
        self._drain()
        self._guarded(self._bag.close)
        if not self.done:
            self._publish_status()

    def _subscription(self, spec: TopicSpec) -> Subscription:
        """Subscribe to a topic, raw; the executor serves only that of the clock."""
        qos = own_qos(
            latched=spec.latched,
            history=HistoryPolicy.KEEP_ALL,
            admits_strangers=self._config.admits_strangers(spec),
        )
        return self.create_subscription(
            message_class(spec.type_name), spec.name, self._hear_clock, qos, raw=True
        )

    def _taker(self, topic: str) -> Callable[[], list[bytes]]:
        """Return the function that takes the waiting messages of a topic; of the log only the run's own."""
        take, loggers = partial(_waiting, self._by_topic[topic]), self._config.own_loggers
        if topic != LOG_TOPIC:
            return take
        return lambda: [line for line in take() if logger_of(line).startswith(loggers)]

    def _hear_clock(self, data: bytes) -> None:
        """Keep a tick, and once every few ticks record all messages and publish the recorder's progress."""
        if self._collector.hear_tick(data):
            self._record()
            self._publish_status()

    def _checkpoint(self) -> None:
        """Take all messages and update the files."""
        self._record(is_checkpoint=True)
        self._publish_status()

    def _record(self, *, is_checkpoint: bool = False) -> int:
        """Take all waiting messages and have them written; return their number."""
        batch = self._collector.batch(is_checkpoint=is_checkpoint)
        if batch.messages or is_checkpoint:
            self._guarded(lambda: self._bag.write(batch))
        return sum(map(len, batch.messages.values()))

    def _drain(self) -> None:
        """Take messages until none has come for a while, since some may still be in transit."""
        limit = time.monotonic() + DRAIN_LIMIT_S
        quiet_at = time.monotonic() + QUIET_BEFORE_CLOSE_S
        while time.monotonic() < min(quiet_at, limit) and not self.done:
            if self._record():
                quiet_at = time.monotonic() + QUIET_BEFORE_CLOSE_S
            else:
                time.sleep(0.01)

    def _guarded(self, write: Callable[[], None]) -> None:
        """Write; if that fails, end with one error. The file stays readable."""
        if self.done:
            return
        try:
            write()
        except BagError as error:
            self.get_logger().error(str(error))
            self.exit_code = EXIT_INTERNAL
            self.done = True

    def _publish_status(self) -> None:
        """Publish the content of the bag, without messages that are still in transit."""
        written = self._bag.written
        status = RecorderStatus(
            ticks=written.ticks, messages=written.messages, bytes=written.bytes, closed=written.closed
        )
        status.header.stamp = Time(nanoseconds=written.now_ns).to_msg()
        self._status.publish(status)


def _waiting(subscription: Subscription) -> list[bytes]:
    """Take every waiting message of a subscription."""
    handle = subscription.handle
    with handle:
        take = partial(handle.take_message, subscription.msg_type, True)
        return [data for data, _ in iter(take, None)]


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return the node; `options` are those of `rclpy.node.Node`."""
    return [RecorderNode(**options)]


def main() -> None:
    """Record until stopped."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
