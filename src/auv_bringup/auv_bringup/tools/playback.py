"""Publish a bag to ROS 2 again, each message when it is due."""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from auv_bag.bag import Bag, RecordedMessage, RecordedTopic
from auv_bag.definitions import DefinitionError, load_message_type
from auv_bag.ros_types import is_latched, message_class, offer_like_recorded
from auv_bag.topics import CLOCK_TOPIC
from auv_bag.writer import BagError
from auv_core.cli.progress import Progress

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.publisher import Publisher

CONNECTION_LIMIT_S = 3.0
ACKNOWLEDGE_LIMIT_S = 2.0
_LONGEST_GAP_S = 60.0
"""A gap that no run has: a stamp in the bag does not belong to its run, as in older bags of real time."""
_SHOW_S = 0.2
_LATEST_NS = (2**31 - 1) * 1_000_000_000
"""The latest time that fits into a message."""


@dataclass(frozen=True)
class _Plan:
    """The topics to publish, and the start time."""

    publishers: dict[str, Any]
    latched: frozenset[str]
    first_ns: int
    last_ns: int


def play(bag: Bag, options: argparse.Namespace) -> None:
    """Publish the bag in the domain of this process."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    topics = _wanted_topics(bag, options.topics, own_clock=options.clock is not None)
    begin_ns, last_ns = bag.span_ns()
    first_ns = begin_ns + round(options.start * 1e9)
    if first_ns > last_ns:
        raise BagError(
            f"--start {options.start:g} is past the end: the bag is {(last_ns - begin_ns) * 1e-9:.3f} s long"
        )
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node("replay", enable_rosout=False, start_parameter_services=False)
        latched = frozenset(name for name in topics if is_latched(bag.topics[name].offered_qos))
        plan = _Plan(_make_publishers(node, bag, topics), latched, first_ns, last_ns)
        clock = _ClockSource(node, options.clock) if options.clock is not None else None
        everything = [*plan.publishers.values(), *([clock.publisher] if clock else [])]
        _wait_for_readers(node, everything, options.delay)
        count = _publish(bag, plan, Pace(first_ns, options.rate), clock)
        _finish(everything)
    finally:
        rclpy.try_shutdown()
    played_s = (last_ns - first_ns) * 1e-9
    print(f"{count} messages of {len(plan.publishers)} topics replayed, {played_s:.3f} s of the bag")


def _wanted_topics(bag: Bag, names: Sequence[str], *, own_clock: bool) -> list[str]:
    """Return the topics to publish."""
    unknown = [name for name in names if name not in bag.topics]
    if unknown:
        raise BagError(f"the bag has no topic {', '.join(unknown)}; it has: {', '.join(bag.topics)}")
    topics = [name for name in names or bag.topics if not (own_clock and name == CLOCK_TOPIC)]
    if not topics:
        raise BagError(f"{bag.folder} has no messages to publish")
    return topics


def _make_publishers(node: Node, bag: Bag, topics: Sequence[str]) -> dict[str, Any]:
    """Return a publisher for each topic whose message type is installed as it was recorded."""
    publishers = {}
    for name in topics:
        topic = bag.topics[name]
        try:
            kind = _class_as_recorded(topic)
        except (BagError, DefinitionError) as error:
            tell(f"note: {name} is left out: {error}")
            continue
        publishers[name] = node.create_publisher(kind, name, offer_like_recorded(topic.offered_qos))
    if not publishers:
        raise BagError(f"no message type of {bag.folder} is installed here")
    return publishers


def _class_as_recorded(topic: RecordedTopic) -> Any:
    """Return the class of a topic's messages; raise BagError if its definition differs from the bag's."""
    kind = message_class(topic.type_name)
    if topic.type_hash and topic.type_hash != load_message_type(topic.type_name).type_hash:
        raise BagError(f"{topic.type_name} is defined differently here than in the bag")
    return kind


def _wait_for_readers(node: Node, publishers: Sequence[Publisher], delay_s: float) -> None:
    """Wait for discovery of readers, and a little longer for their connection."""
    _pause(delay_s)
    limit_s = time.monotonic() + CONNECTION_LIMIT_S
    while time.monotonic() < limit_s:
        connected = all(
            publisher.get_subscription_count() >= node.count_subscribers(publisher.topic_name)
            for publisher in publishers
        )
        if connected:
            return
        _pause(0.02)


class Pace:
    """Maps times of the bag to the steady clock."""

    def __init__(self, first_ns: int, rate: float) -> None:
        self._first_ns, self._rate = first_ns, rate
        self._reached_ns = first_ns
        self._began_s = time.monotonic()

    def leave_out_gap(self, time_ns: int) -> None:
        """Skip a long gap before the next message, which has this time."""
        gap_ns = time_ns - self._reached_ns
        if gap_ns > _LONGEST_GAP_S * 1e9:
            tell(f"note: the bag has no messages for {gap_ns * 1e-9:.1f} s; the replay skips this time")
            self._first_ns += gap_ns
        self._reached_ns = max(self._reached_ns, time_ns)

    def due_s(self, time_ns: int) -> float:
        """Return the wall time (s) of a moment of the bag."""
        return self._began_s + (time_ns - self._first_ns) * 1e-9 / self._rate

    def bag_time_ns(self, wall_s: float) -> int:
        """Return the moment of the bag (ns) at a wall time."""
        return self._first_ns + round((wall_s - self._began_s) * self._rate * 1e9)


class _ClockSource:
    """Publishes /clock at a steady rate of wall time."""

    def __init__(self, node: Node, rate_hz: float) -> None:
        from rosgraph_msgs.msg import Clock

        self._message = Clock()
        self.publisher = node.create_publisher(Clock, CLOCK_TOPIC, 10)
        self._period_s = 1.0 / rate_hz
        self._next_s = 0.0

    def run_until(self, due_s: float, pace: Pace) -> None:
        """Publish the ticks up to a wall time, each when it is due."""
        self._next_s = self._next_s or time.monotonic()
        while self._next_s <= due_s:
            _pause(self._next_s - time.monotonic())
            time_ns = min(max(pace.bag_time_ns(self._next_s), 0), _LATEST_NS)
            seconds, nanoseconds = divmod(time_ns, 1_000_000_000)
            self._message.clock.sec, self._message.clock.nanosec = seconds, nanoseconds
            self.publisher.publish(self._message)
            self._next_s += self._period_s


def _publish(bag: Bag, plan: _Plan, pace: Pace, clock: _ClockSource | None) -> int:
    """Publish every message when it is due; return their number."""
    count = 0
    with Progress((plan.last_ns - plan.first_ns) * 1e-9, verb="replayed") as progress:
        shown_s = -math.inf
        for message in _messages(bag, plan):
            pace.leave_out_gap(message.time_ns)
            due_s = pace.due_s(message.time_ns)
            while True:
                now_s = time.monotonic()
                if now_s - shown_s > _SHOW_S:
                    shown_s = now_s
                    progress.update((pace.bag_time_ns(min(now_s, due_s)) - plan.first_ns) * 1e-9)
                if now_s >= due_s:
                    break
                next_s = min(due_s, now_s + _SHOW_S)
                if clock is not None:
                    clock.run_until(next_s, pace)
                _pause(next_s - time.monotonic())
            plan.publishers[message.topic].publish(message.data)
            count += 1
    return count


def _messages(bag: Bag, plan: _Plan) -> Iterator[RecordedMessage]:
    """Yield the messages to publish: first latched ones from before the start, then all from there on."""
    for message in bag.messages(plan.latched & plan.publishers.keys()):
        if message.time_ns >= plan.first_ns:
            break
        yield message
    yield from bag.messages(plan.publishers.keys(), plan.first_ns)


def _finish(publishers: Sequence[Publisher]) -> None:
    """Wait, within a limit, until every reliable reader has received all messages."""
    from rclpy.duration import Duration

    limit_s = time.monotonic() + ACKNOWLEDGE_LIMIT_S
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, limit_s - time.monotonic())))


def _pause(duration_s: float) -> None:
    """Wait on the wall clock; Ctrl-C ends it at once."""
    if duration_s > 0.0:
        threading.Event().wait(duration_s)


def tell(line: str) -> None:
    """Print a line for the user without breaking the progress bar."""
    print(line, file=sys.stderr)
