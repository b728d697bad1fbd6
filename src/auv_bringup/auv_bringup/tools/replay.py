"""Command `./scripts/replay`: publish a recorded bag again, or run its neighbour filters again."""

from __future__ import annotations

import argparse
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_bag.bag import Bag, RecordedMessage, RecordedTopic
from auv_bag.definitions import DefinitionError, load_message_type
from auv_bag.mend import mend_bag
from auv_bag.ros_types import is_latched, message_class, offer_like_recorded
from auv_bag.topics import CLOCK_TOPIC
from auv_bag.writer import BagError
from auv_bringup.launching.domains import DomainError, claim_domain
from auv_bringup.launching.node_start import export_line
from auv_bringup.tools.environment import prepare_environment
from auv_core.cli.failures import answered
from auv_core.cli.one_line_parser import OneLineParser, refusal
from auv_core.cli.progress import Progress
from auv_core.params import ConfigError

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.publisher import Publisher

    from auv_experiment.re_estimate import Comparison

EXIT_DONE, EXIT_DIFFERENT, EXIT_INTERNAL = 0, 1, 3
DEFAULT_CLOCK_HZ = 40.0
DEFAULT_DELAY_S = 1.0
CONNECTION_LIMIT_S = 3.0
ACKNOWLEDGE_LIMIT_S = 2.0
_LONGEST_GAP_S = 60.0
"""A silence that no run has: a bag with a stamp that is not of its run, as older ones in real time."""
_SHOW_S = 0.2
_LATEST_NS = (2**31 - 1) * 1_000_000_000
"""The latest time that a message can state."""

_EPILOG = """\
A recorded /clock is published as it was, unless --clock makes a new one.

exit status:
  0    done
  1    --re-estimate gives other estimates than the recorded ones
  2    bad input
  3    internal error
  130  Ctrl-C

examples:
  ./scripts/replay results/flock_acoustic-1-lockstep --rate 10
  ./scripts/replay results/flock_acoustic-1-lockstep --start 300 --clock
  ./scripts/replay results/flock_acoustic-1-lockstep --re-estimate
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    return answered(
        lambda: _do(_parse(argv)),
        (BagError, ConfigError),
        interrupted="interrupted",
        outlives_its_reader=False,
        failed=EXIT_INTERNAL,
    )


def _do(options: argparse.Namespace) -> int:
    for note in mend_bag(options.bag):
        _tell(f"note: {note}")
    bag = Bag(options.bag)
    return _re_estimate(bag) if options.re_estimate else _replay(bag, options)


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = OneLineParser(
        prog="./scripts/replay",
        description="Publish a recorded bag again, with the recorded types, QoS and timing.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="bag folder, or results folder with a bag in it"
    )
    parser.add_argument(
        "--rate", type=_number_of(0.001, 1e6), default=1.0, metavar="R", help="speed, 1 is as recorded"
    )
    parser.add_argument(
        "--start",
        type=_number_of(0.0, 1e9),
        default=0.0,
        metavar="S",
        help="seconds into the bag to start at",
    )
    parser.add_argument(
        "--clock",
        type=_number_of(0.01, 10_000.0),
        nargs="?",
        const=DEFAULT_CLOCK_HZ,
        metavar="HZ",
        help=f"make a /clock from the time of the bag, so often per wall second ({DEFAULT_CLOCK_HZ:g})",
    )
    parser.add_argument(
        "--delay",
        type=_number_of(0.0, 3600.0),
        default=DEFAULT_DELAY_S,
        metavar="S",
        help=f"wall seconds before the first message, for readers to be found ({DEFAULT_DELAY_S:g})",
    )
    parser.add_argument("--topics", nargs="+", default=[], metavar="T", help="publish these topics only")
    parser.add_argument(
        "--discovery",
        choices=("localhost", "subnet"),
        default="localhost",
        help="who may hear it: this machine (default), or the whole subnet",
    )
    parser.add_argument(
        "--re-estimate",
        action="store_true",
        help="do not publish: run the neighbour filters again from the recorded packets and compare",
    )
    return parser.parse_args(argv)


def _number_of(least: float, most: float) -> Callable[[str], float]:
    """Return the type function of an argument that is a number between two bounds."""

    def number(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most:
            raise refusal(text, f"a number from {least:g} to {most:g}")
        return value

    return number


def _re_estimate(bag: Bag) -> int:
    """Run the filters again and report the differences."""
    from auv_core.compiled import use_compiler
    from auv_experiment.compose import input_limits
    from auv_experiment.re_estimate import re_estimate
    from auv_experiment.scenario.loading import load_scenario
    from auv_flocking.agent import make_consensus, make_format

    scenario_file = bag.folder.parent / "scenario.yaml"
    if not scenario_file.is_file():
        raise BagError(f"{scenario_file} is missing; --re-estimate takes the filter settings from it")
    scenario = load_scenario(str(scenario_file))
    vehicle_ids = [vehicle.id for vehicle in scenario.vehicles]
    settings = scenario.agent
    report_format = make_format(settings.report, make_consensus(settings.consensus, len(vehicle_ids)))
    use_compiler(print)
    result = re_estimate(
        bag, vehicle_ids, settings.neighbours, report_format, scenario.period_s, input_limits(scenario)
    )
    _report_comparison(result, len(vehicle_ids))
    return EXIT_DONE if result.agrees else EXIT_DIFFERENT


def _report_comparison(result: Comparison, n_vehicles: int) -> None:
    """Print what the comparison found."""
    print(f"{result.estimates} estimates of {n_vehicles} vehicles in {result.ticks} vehicle ticks compared")
    print(f"  position     max difference {result.position_m:.3g} m")
    print(f"  velocity     max difference {result.velocity_mps:.3g} m/s")
    print(f"  covariance   max difference {result.covariance:.3g}")
    if result.unmatched:
        print(f"  {result.unmatched} estimates are on one side only")
    if result.unused_ticks:
        print(f"  {result.unused_ticks} vehicle ticks left out: the bag lacks packets before them")
    print(
        "the recorded packets give the recorded estimates"
        if result.agrees
        else "they DIFFER by more than 1e-9"
    )


@dataclass(frozen=True)
class _Plan:
    """What to publish, and from when."""

    publishers: dict[str, Any]
    latched: frozenset[str]
    first_ns: int
    last_ns: int


def _replay(bag: Bag, options: argparse.Namespace) -> int:
    """Publish the bag in a domain of its own, as a run flies in one."""
    try:
        claim = claim_domain(os.environ)
    except DomainError as error:
        raise BagError(str(error)) from None
    with claim:
        if claim.is_moved:
            _tell(
                f"ROS domain {claim.asked_id} is in use by another run; this replay takes domain "
                f"{claim.domain_id}; to look in:  {export_line(claim.domain_id, options.discovery)}"
            )
        os.environ["ROS_DOMAIN_ID"] = str(claim.domain_id)
        prepare_environment(options.discovery)
        return _play(bag, options)


def _play(bag: Bag, options: argparse.Namespace) -> int:
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
        count = _publish(bag, plan, _Pace(first_ns, options.rate), clock)
        _finish(everything)
    finally:
        rclpy.try_shutdown()
    played_s = (last_ns - first_ns) * 1e-9
    print(f"{count} messages of {len(plan.publishers)} topics replayed, {played_s:.3f} s of the bag")
    return EXIT_DONE


def _wanted_topics(bag: Bag, names: Sequence[str], *, own_clock: bool) -> list[str]:
    """Return the topics to publish."""
    unknown = [name for name in names if name not in bag.topics]
    if unknown:
        raise BagError(f"the bag has no topic {', '.join(unknown)}; it has: {', '.join(bag.topics)}")
    topics = [name for name in names or bag.topics if not (own_clock and name == CLOCK_TOPIC)]
    if not topics:
        raise BagError(f"{bag.folder} holds nothing to publish")
    return topics


def _make_publishers(node: Node, bag: Bag, topics: Sequence[str]) -> dict[str, Any]:
    """Return a publisher for each topic whose message type is installed as it was recorded."""
    publishers = {}
    for name in topics:
        topic = bag.topics[name]
        try:
            kind = _class_as_recorded(topic)
        except (BagError, DefinitionError) as error:
            _tell(f"note: {name} is left out: {error}")
            continue
        publishers[name] = node.create_publisher(kind, name, offer_like_recorded(topic.offered_qos))
    if not publishers:
        raise BagError(f"no message type of {bag.folder} is installed here")
    return publishers


def _class_as_recorded(topic: RecordedTopic) -> Any:
    """Return the class of a topic's messages; raise BagError where its definition is not that of the bag."""
    kind = message_class(topic.type_name)
    if topic.type_hash and topic.type_hash != load_message_type(topic.type_name).type_hash:
        raise BagError(f"{topic.type_name} is defined otherwise here than in the bag")
    return kind


def _wait_for_readers(node: Node, publishers: Sequence[Publisher], delay_s: float) -> None:
    """Wait a while for readers to be found, and a little longer for those that were to be connected."""
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


class _Pace:
    """When a moment of the bag is due, by the steady clock."""

    def __init__(self, first_ns: int, rate: float) -> None:
        self._first_ns, self._rate = first_ns, rate
        self._reached_ns = first_ns
        self._began_s = time.monotonic()

    def leave_out_gap(self, time_ns: int) -> None:
        """Go on at once where the next message, of this time, comes after a long silence."""
        gap_ns = time_ns - self._reached_ns
        if gap_ns > _LONGEST_GAP_S * 1e9:
            _tell(f"note: the bag has nothing for {gap_ns * 1e-9:.1f} s; the replay goes on at once")
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

    def run_until(self, due_s: float, pace: _Pace) -> None:
        """Publish the ticks up to a wall time, each when it is due."""
        self._next_s = self._next_s or time.monotonic()
        while self._next_s <= due_s:
            _pause(self._next_s - time.monotonic())
            time_ns = min(max(pace.bag_time_ns(self._next_s), 0), _LATEST_NS)
            seconds, nanoseconds = divmod(time_ns, 1_000_000_000)
            self._message.clock.sec, self._message.clock.nanosec = seconds, nanoseconds
            self.publisher.publish(self._message)
            self._next_s += self._period_s


def _publish(bag: Bag, plan: _Plan, pace: _Pace, clock: _ClockSource | None) -> int:
    """Publish every message when it is due; return how many there were."""
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
    """Yield what to publish: first what was latched before the start, then everything from there on."""
    for message in bag.messages(plan.latched & plan.publishers.keys()):
        if message.time_ns >= plan.first_ns:
            break
        yield message
    yield from bag.messages(plan.publishers.keys(), plan.first_ns)


def _finish(publishers: Sequence[Publisher]) -> None:
    """Wait, within a limit, until every reliable reader has everything."""
    from rclpy.duration import Duration

    limit_s = time.monotonic() + ACKNOWLEDGE_LIMIT_S
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, limit_s - time.monotonic())))


def _pause(duration_s: float) -> None:
    """Wait on the wall clock; Ctrl-C ends it at once."""
    if duration_s > 0.0:
        threading.Event().wait(duration_s)


def _tell(line: str) -> None:
    """Print a line for the user, beside the progress bar."""
    print(line, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
