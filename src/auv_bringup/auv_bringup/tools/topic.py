"""Command `./scripts/topic`: list, echo, hz and info for machines without the ros2 command line."""

from __future__ import annotations

import argparse
import difflib
import os
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from auv_bag.ros_types import message_class
from auv_bag.writer import BagError
from auv_bringup.tools.environment import prepare_environment
from auv_bringup.tools.silence import Silence
from auv_bringup.tools.topic_words import describe_rate, message_to_yaml
from auv_core.cli.failures import DONE, answered
from auv_core.cli.one_line_parser import OneLineParser, read_argument
from auv_core.cli.printable import printable
from auv_core.machine.interrupts import held_interrupts

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.qos import QoSProfile

WINDOW = 10_000
REPORT_PERIOD_S = 1.0
SETTLED_S = 0.5
UNNAMED = "_NODE_NAME_UNKNOWN_"
_LOOK_S = 0.1

_EPILOG = """\
`./scripts/topic echo --help` describes one of them; likewise for the others.

examples:
  ./scripts/topic list --show-types
  ./scripts/topic echo /auv_1/odom --once
  ./scripts/topic hz /auv_1/odom
  ./scripts/topic info /auv_1/odom --verbose
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    return answered(lambda: _do(_parse(argv)), (BagError,), interrupted="", outlives_its_reader=False)


def _do(options: argparse.Namespace) -> int:
    prepare_environment(options.discovery)
    with _node() as node:
        return int(options.run(node, options))


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = OneLineParser(
        prog="./scripts/topic",
        description="Inspect the topics of $ROS_DOMAIN_ID.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--discovery", choices=("localhost", "subnet"), default="localhost", help="where to look"
    )
    parser.add_argument(
        "--wait", type=_positive, default=3.0, metavar="S", help="longest time to look for topics (3)"
    )
    parser.add_argument(
        "--silence",
        type=_positive,
        default=60.0,
        metavar="S",
        help="echo and hz: longest time between two messages (60)",
    )
    verbs = parser.add_subparsers(required=True, metavar="list|echo|hz|info")
    verb = verbs.add_parser("list", help="names of all topics")
    verb.add_argument("-t", "--show-types", action="store_true", help="with their types")
    verb.set_defaults(run=_list)
    verb = verbs.add_parser("echo", help="print messages")
    verb.add_argument("topic")
    verb.add_argument("--once", dest="count", action="store_const", const=1, help="stop after one message")
    verb.add_argument("-n", "--count", dest="count", type=_count, metavar="N", help="stop after N messages")
    verb.set_defaults(run=_echo)
    verb = verbs.add_parser("hz", help="rate of messages")
    verb.add_argument("topic")
    verb.add_argument(
        "--window", type=_count, default=WINDOW, metavar="N", help=f"average over N messages ({WINDOW})"
    )
    verb.set_defaults(run=_hz)
    verb = verbs.add_parser("info", help="type, publishers and subscribers")
    verb.add_argument("topic")
    verb.add_argument("-v", "--verbose", action="store_true", help="with node names, QoS and type hash")
    verb.set_defaults(run=_info)
    return parser.parse_args(argv)


def _positive(text: str) -> float:
    """Return a number above zero, at most an hour."""
    allowed = "a number of seconds above 0 and at most 3600"
    return read_argument(text, float, lambda value: 0.0 < value <= 3600.0, allowed)


def _count(text: str) -> int:
    """Return a whole number from 1."""
    return read_argument(text, int, lambda value: value >= 1, "a whole number of at least 1")


@contextmanager
def _node() -> Iterator[Node]:
    """Yield a node that is hidden from others as far as possible."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    with held_interrupts():
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        node = rclpy.create_node(f"_topic_{os.getpid()}", enable_rosout=False, start_parameter_services=False)
    try:
        yield node
    finally:
        rclpy.try_shutdown()


def _list(node: Node, options: argparse.Namespace) -> int:
    """Print all topics, once no new ones appear."""
    for name, types in sorted(_settled_topics(node, options.wait).items()):
        print(printable(f"{name} [{', '.join(types)}]" if options.show_types else name))
    return DONE


def _info(node: Node, options: argparse.Namespace) -> int:
    """Print the graph's data about a topic."""
    type_name = _find_type(node, options.topic, options.wait)
    publishers, subscribers = _named_endpoints(node, options.topic, options.wait)
    gap = "\n" if options.verbose else ""
    print(f"Type: {type_name}{gap}")
    for word, infos in (("Publisher", publishers), ("Subscription", subscribers)):
        print(f"{word} count: {len(infos)}{gap}")
        if options.verbose:
            for info in infos:
                print(printable(f"{info}\n"))
    return DONE


def _echo(node: Node, options: argparse.Namespace) -> int:
    """Print messages as YAML."""
    left = options.count

    def show(message: Any) -> bool:
        nonlocal left
        print(message_to_yaml(message), end="---\n", flush=True)
        left = None if left is None else left - 1
        return left == 0

    _receive(node, options, show)
    return DONE


def _hz(node: Node, options: argparse.Namespace) -> int:
    """Print the rate once a second, until interrupted."""
    arrivals_s: deque[float] = deque(maxlen=options.window + 1)
    reported_s = time.monotonic()

    def note(_: bytes) -> bool:
        nonlocal reported_s
        now_s = time.monotonic()
        arrivals_s.append(now_s)
        if now_s - reported_s >= REPORT_PERIOD_S and len(arrivals_s) > 1:
            reported_s = now_s
            print(describe_rate(tuple(arrivals_s)), flush=True)
        return False

    _receive(node, options, note, raw=True)
    return DONE


def _receive(
    node: Node, options: argparse.Namespace, take: Callable[[Any], bool], *, raw: bool = False
) -> None:
    """Pass each message of a topic to a function until it returns True; give up after a long silence."""
    from rclpy.executors import SingleThreadedExecutor

    kind = message_class(_find_type(node, options.topic, options.wait))
    finished = False
    silence = Silence(options.silence, time.monotonic)

    def callback(message: Any) -> None:
        nonlocal finished
        silence.end()
        finished = finished or take(message)

    with held_interrupts():
        node.create_subscription(kind, options.topic, callback, _matching_qos(node, options.topic), raw=raw)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
    while not finished:
        with held_interrupts():
            executor.spin_once(timeout_sec=_LOOK_S)
        if silence.is_to_be_said():
            _say_silence(node, options.topic, silence)


def _say_silence(node: Node, topic: str, silence: Silence) -> None:
    """Print what the command waits for, or give up."""
    count = node.count_publishers(topic)
    words = f"no message of {topic} for {silence.lasts_s:.0f} s ({count} publisher{'s' * (count != 1)})"
    if silence.is_too_long:
        raise BagError(words)
    print(f"note: {words}; Ctrl-C ends the wait", file=sys.stderr, flush=True)


def _find_type(node: Node, topic: str, wait_s: float) -> str:
    """Return a topic's type, once the topic exists."""
    limit_s = time.monotonic() + wait_s
    while time.monotonic() < limit_s:
        types = _topics(node).get(topic)
        if types:
            return types[0]
        _spin(node)
    raise BagError(_unknown_topic(topic, sorted(_topics(node)), wait_s))


def _named_endpoints(node: Node, topic: str, wait_s: float) -> tuple[list[Any], list[Any]]:
    """Return publishers and subscribers, once the names of their nodes are known, which come later."""
    limit_s = time.monotonic() + wait_s
    while True:
        publishers = node.get_publishers_info_by_topic(topic)
        subscribers = node.get_subscriptions_info_by_topic(topic)
        unnamed = [each for each in (*publishers, *subscribers) if each.node_name == UNNAMED]
        if not unnamed or time.monotonic() >= limit_s:
            return publishers, subscribers
        _spin(node)


def _unknown_topic(topic: str, known: Sequence[str], wait_s: float) -> str:
    """Return the message about a topic that does not exist."""
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    said = f"no topic {topic} in ROS domain {domain} after {wait_s:g} s"
    near = (
        difflib.get_close_matches(topic, known, n=3)
        or [name for name in known if topic.strip("/") in name][:3]
    )
    if near:
        return f"{said}; did you mean {', '.join(near)}?"
    if set(known) - {"/rosout", "/parameter_events"}:
        return f"{said}; `./scripts/topic list` shows all topics"
    return f"{said}, nor any other; is a run under way, and in this domain (`export ROS_DOMAIN_ID=...`)?"


def _settled_topics(node: Node, wait_s: float) -> dict[str, list[str]]:
    """Return all topics, once other nodes have some and none has been added for a while."""
    limit_s = time.monotonic() + wait_s
    own = topics = _topics(node)
    changed_s = time.monotonic()
    while (now_s := time.monotonic()) < limit_s:
        _spin(node)
        found = _topics(node)
        if found.keys() != topics.keys():
            topics, changed_s = found, now_s
        elif topics.keys() != own.keys() and now_s - changed_s >= SETTLED_S:
            break
    return topics


def _topics(node: Node) -> dict[str, list[str]]:
    """Return types by topic, as far as they are known."""
    return dict(node.get_topic_names_and_types())


def _spin(node: Node) -> None:
    """Wait a moment for discovery."""
    import rclpy

    with held_interrupts():
        rclpy.spin_once(node, timeout_sec=_LOOK_S)


def _matching_qos(node: Node, topic: str) -> QoSProfile:
    """
    Return a profile that matches every publisher of a topic; it gets latched messages if all publishers
    latch.
    """
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    offers = [info.qos_profile for info in node.get_publishers_info_by_topic(topic)]
    reliable = all(offer.reliability == ReliabilityPolicy.RELIABLE for offer in offers)
    latched = bool(offers) and all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=100,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


if __name__ == "__main__":
    sys.exit(main())
