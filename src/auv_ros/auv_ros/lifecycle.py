"""
The life of a ROS process of this project: start, spin, stop.

Spinning is done by rclpy's EventsExecutor with finite time-outs (without one it spins without end in the
wheels that are published), and by the SingleThreadedExecutor where that one is missing. SIGINT and SIGTERM
only set a flag, however often they come, so that a node always finishes what it is doing, hands over what it
has published, and leaves with its own exit status. A SIGTERM that follows another signal says that nobody
will acknowledge what is left to hand over.
"""

from __future__ import annotations

import math
import signal
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.topic_endpoint_info import TopicEndpointInfo

from auv_core.machine.leaving import leave
from auv_core.params import ConfigError
from auv_msgs.msg import FlockStatus
from auv_ros.hearing import Hearing
from auv_ros.joining import Joining
from auv_ros.parameters import refuse_unknown_parameters
from auv_ros.qos import LATCHED
from auv_ros.run_config import RunConfig, TickClock, WallWatch
from auv_ros.run_identity import status_epoch_s
from auv_ros.run_watch import RunEnd, listed, say_waits
from auv_ros.steady_timer import NEVER_S, SteadyTimer
from auv_ros.strangers import full_name

_WAKE_S = 0.25
_SWITCH_S = 1e-4
"""How long a thread waits for Python's lock before it asks for it, see `auv_ros.steady_timer`."""
_HAND_OVER_S = 5.0
_HAND_OVER_UNSEEN_S = 0.5
_HAND_OVER_LOOK = Duration(nanoseconds=100_000_000)
_LOOK_S = 0.02
_STRANGERS_S = 3.0
"""Longest wait for readers that are not the run's own, once its own are there."""

WAITS_FOR_RUN = "the run to begin: /flock/status of /clock_node"


def main_loop(make_nodes: Callable[[], Sequence[Node]], arguments: Sequence[str] | None = None) -> int:
    """
    Run nodes until a signal comes or one of them is done; return the exit status.

    Where the system clock was stepped meanwhile, the process ends here, see `auv_core.machine.leaving`.

    Parameters
    ----------
    make_nodes : callable
        Makes the nodes, after ``rclpy.init``.  A node may have ``done`` (true when the process must end),
        ``exit_code``, ``on_stop()``, which is called once, before the node is destroyed, ``waits_for()``,
        words that are said every 5 s as long as there are any, and ``on_run_end()``.  The process ends some
        seconds after its run.
    arguments : sequence of str, optional
        ROS arguments of all nodes; those of the command line if left out.

    Returns
    -------
    status : int
        2 after a parameter that cannot be used (one line on standard error), 1 after an exception (whose last
        line on standard error names the node), else the largest ``exit_code`` of the nodes.

    """
    sys.setswitchinterval(_SWITCH_S)
    stopping: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _frame: stopping.append(received))
    given = sys.argv if arguments is None else arguments
    rclpy.init(args=list(given), signal_handler_options=SignalHandlerOptions.NO)
    wall = WallWatch(time.monotonic, time.time)
    nodes: Sequence[Node] = ()
    status = 0
    try:
        nodes = make_nodes()
        refuse_unknown_parameters(nodes)
        for node in nodes:
            node.add_on_set_parameters_callback(_refuse_changes)
            say_waits(node)
        run_end = RunEnd(nodes)
        _spin(nodes, lambda: bool(stopping) or run_end.is_past())
    except ConfigError as error:
        sys.stderr.write(f"error: {error}\n")
        status = 2
    except Exception as error:
        traceback.print_exception(error)
        words = " ".join(str(error).split())
        sys.stderr.write(f"{_raised_in(error)}: {type(error).__name__}: {words}\n")
        status = 1
    try:
        for node in nodes:
            getattr(node, "on_stop", _nothing)()
        is_clock_stepped = bool(wall.warning())
        _hand_over(
            nodes,
            is_in_vain=lambda: signal.SIGTERM in stopping[1:],
            is_clock_stepped=is_clock_stepped,
        )
        status = status or max((getattr(node, "exit_code", 0) for node in nodes), default=0)
        if is_clock_stepped:
            leave(status)
        return status
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
        # Python drops its handlers while it shuts down: a late signal would then kill the process.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)


def _spin(nodes: Sequence[Node], is_stopped: Callable[[], bool]) -> None:
    """Run the nodes until told to stop, or one of them is done, or a timer of one fails."""
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    woken = Future()
    waker = SteadyTimer(nodes[0], _WAKE_S, lambda: woken.set_result(None))
    try:
        while not is_stopped() and not any(getattr(node, "done", False) for node in nodes):
            executor.spin_until_future_complete(woken, timeout_sec=NEVER_S)
            woken = Future()
            for node in nodes:
                if error := getattr(node, "timer_error", None):
                    raise error
    finally:
        waker.cancel()


def make_executor(context: Context | None = None) -> Executor:
    """Return an EventsExecutor where there is one, else a SingleThreadedExecutor."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def publishes_bytes(publisher: Publisher) -> Callable[[bytes], None]:
    """
    Return what publishes serialised messages, for messages of every tick.

    It is what `Publisher.publish` calls after it has looked at the type of the message and taken a lock that
    a process of one thread does not need.
    """
    publish: Callable[[bytes], None] = publisher.handle.publish_raw
    return publish


def tick_clock(run: RunConfig, period_s: float) -> TickClock:
    """Return the clock of a run on this machine's steady clock."""
    return TickClock(run, period_s, time.monotonic, time.time)


def when_running(node: Node, ticks: TickClock, begin: Callable[[], None]) -> None:
    """Call `begin` once scenario time 0 is known, from the configuration or from the status of the run."""
    if ticks.started:
        begin()
        return
    joining = Joining(ticks.scenario_s(1))

    def on_status(status: FlockStatus) -> None:
        if status.state == FlockStatus.WAITING:
            joining.wait()
        epoch_s = status_epoch_s(status)
        is_possible = epoch_s > 0.0 and 0.0 <= status.time_s < status.duration_s
        if ticks.started or status.state != FlockStatus.RUNNING or not is_possible:
            return
        off_s = joining.hear(status.time_s, time.time() - epoch_s, time.monotonic())
        if off_s is None:
            return
        if off_s:
            node.get_logger().warning(
                f"the system clock is {off_s:+.1f} s off that of the run; the run's is followed"
            )
        ticks.join(epoch_s, off_s)
        begin()

    Hearing(node).listen_decoded(FlockStatus, "/flock/status", on_status, LATCHED)


def _refuse_changes(parameters: Sequence[Parameter]) -> SetParametersResult:
    """Refuse to set a parameter of a node that runs, a built-in one like `use_sim_time` too."""
    names = ", ".join(parameter.name for parameter in parameters)
    return SetParametersResult(
        successful=False, reason=f"{names}: not changed; parameters are set when a node starts"
    )


@dataclass(frozen=True)
class Audience:
    """A publisher and the full names of the nodes that must hear it from the first message on."""

    publisher: Publisher
    nodes: frozenset[str]


class Rendezvous:
    """
    Waits until every publisher of a node is matched with all that must hear it, then calls `on_ready` once.

    A reliable writer that has matched a reader delivers everything from then on; so nothing of a run is
    lost, however slowly its processes find each other.
    """

    def __init__(self, node: Node, audiences: Iterable[Audience], on_ready: Callable[[], None]) -> None:
        self._node = node
        self._waiting = list(audiences)
        self._on_ready = on_ready
        self._offers: dict[str, list[TopicEndpointInfo]] = {}
        self._alone_since_s = math.inf
        self.ready = False
        self._timer = SteadyTimer(node, _LOOK_S, self._look)

    def missing(self) -> list[str]:
        """Return the full names of the nodes not found, or found and not connected, yet; sorted."""
        absent = set().union(*(self._absent(audience) for audience in self._waiting))
        return sorted(absent or set().union(*(audience.nodes for audience in self._waiting)))

    def waits_for(self) -> str:
        """Return who is missing, or which topics are not matched, in words."""
        topics = [audience.publisher.topic_name for audience in self._waiting]
        return listed(self.missing()) or listed(topics)

    def _look(self) -> None:
        self._waiting = [audience for audience in self._waiting if not self._complete(audience)]
        if not self._waiting and not self.ready:
            self.ready = True
            self._timer.cancel()
            self._on_ready()

    def _complete(self, audience: Audience) -> bool:
        """
        Return whether a publisher has matched all of its audience.

        It says how many readers it has matched, not which; so those of strangers are waited for too, where
        they can match at all, and not for long.
        """
        matched = audience.publisher.get_subscription_count()
        if matched < len(audience.nodes):
            return False  # without a look at the graph, which costs much in a large fleet
        readers = self._readers(audience)
        if not audience.nodes <= set(readers):
            self._alone_since_s = math.inf
            return False
        self._alone_since_s = min(self._alone_since_s, time.monotonic())
        if time.monotonic() - self._alone_since_s > _STRANGERS_S:
            readers = [name for name in readers if name in audience.nodes]
        return matched >= len(readers)

    def _absent(self, audience: Audience) -> set[str]:
        return set(audience.nodes) - set(self._readers(audience))

    def _readers(self, audience: Audience) -> list[str]:
        """Return the readers that can match: of this type, and asking for no more than is offered."""
        topic = audience.publisher.topic_name
        own = self._offered(topic)
        return [
            full_name(info)
            for info in self._node.get_subscriptions_info_by_topic(topic)
            if all(_can_match(offer, info) for offer in own)
        ]

    def _offered(self, topic: str) -> list[TopicEndpointInfo]:
        """Return what the graph says that we offer: it has the middleware's defaults filled in."""
        if topic not in self._offers:
            own_name = self._node.get_fully_qualified_name()
            infos = self._node.get_publishers_info_by_topic(topic)
            found = [info for info in infos if full_name(info) == own_name]
            if not found:
                return []
            self._offers[topic] = found
        return self._offers[topic]


def _can_match(offer: TopicEndpointInfo, reader: TopicEndpointInfo) -> bool:
    compatible = qos_check_compatible(offer.qos_profile, reader.qos_profile)[0] != QoSCompatibility.ERROR
    return compatible and offer.topic_type == reader.topic_type


def _hand_over(nodes: Sequence[Node], *, is_in_vain: Callable[[], bool], is_clock_stepped: bool) -> None:
    """
    Wait, not for long, until every reader has what was published to it, or until that `is_in_vain`.

    A publisher whose reader is dead does not keep the others from being waited for.

    The middleware waits until a time of the system clock. Where that was stepped, its waits may be endless,
    and Python stands still for as long: a short time must do.
    """
    if is_clock_stepped:
        time.sleep(_HAND_OVER_UNSEEN_S)
        return
    deadline = time.monotonic() + _HAND_OVER_S
    waiting = deque(publisher for node in nodes for publisher in node.publishers)
    while waiting and time.monotonic() < deadline and not is_in_vain():
        publisher = waiting.popleft()
        if not publisher.wait_for_all_acked(_HAND_OVER_LOOK):
            waiting.append(publisher)


def _raised_in(error: BaseException) -> str:
    """Return the full name of the node in whose method an exception was raised."""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        owner = frame.f_locals.get("self")
        if isinstance(owner, Node):
            return str(owner.get_fully_qualified_name())
    return "error"


def _nothing() -> None:
    pass
