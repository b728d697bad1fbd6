"""
The life cycle of a ROS process of this project: start, spin, stop.

The process spins with rclpy's EventsExecutor with finite time-outs (without a time-out it never returns in
the published wheels), or with the SingleThreadedExecutor if the former is missing. SIGINT and SIGTERM only
set a flag, however often they come, so that a node always finishes its current work, delivers its published
messages, and ends with its own exit status. A SIGTERM after another signal means that readers will not
acknowledge the remaining messages.
"""

from __future__ import annotations

import signal
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Sequence

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from auv_core.machine.leaving import leave
from auv_core.params import ConfigError
from auv_ros.parameters import refuse_unknown_parameters
from auv_ros.run_config import WallWatch
from auv_ros.run_watch import RunEnd, say_waits
from auv_ros.steady_timer import NEVER_S, SteadyTimer

_WAKE_S = 0.25
_SWITCH_S = 1e-4
"""How long a thread waits before it requests Python's lock, see `auv_ros.steady_timer`."""
_HAND_OVER_S = 5.0
_HAND_OVER_LOST_S = 1.5
"""The same in a lost run, since dead processes never acknowledge."""
_LOST_STATUS = 3
_HAND_OVER_UNSEEN_S = 2.5
"""The same after a step of the system clock: nothing tells when a message has come, and it may come late."""
_HAND_OVER_LOOK = Duration(nanoseconds=100_000_000)


def main_loop(make_nodes: Callable[[], Sequence[Node]], arguments: Sequence[str] | None = None) -> int:
    """
    Run nodes until a signal comes or one of them is done; return the exit status.

    Where the system clock was stepped meanwhile, the process ends here, see `auv_core.machine.leaving`.

    Parameters
    ----------
    make_nodes : callable
        Makes the nodes, after ``rclpy.init``.  A node may have ``done`` (true when the process must end),
        ``exit_code``, ``on_stop()``, which is called once, before the node is destroyed, ``waits_for()``,
        a text that is logged every 5 s unless it is empty, and ``on_run_end()``.  The process ends some
        seconds after its run.
    arguments : sequence of str, optional
        ROS arguments of all nodes; those of the command line if left out.

    Returns
    -------
    status : int
        2 after a parameter that cannot be used (one line on standard error), 1 after an exception (whose last
        line on standard error names the node), otherwise the largest ``exit_code`` of the nodes.

    """
    sys.setswitchinterval(_SWITCH_S)
    stopping: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _frame: stopping.append(received))
    given = sys.argv if arguments is None else arguments
    rclpy.init(args=list(given), signal_handler_options=SignalHandlerOptions.NO)
    wall = WallWatch(time.monotonic, time.time)
    nodes: Sequence[Node] = ()
    run_end: RunEnd | None = None
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
        status = status or max((getattr(node, "exit_code", 0) for node in nodes), default=0)
        is_lost = status == _LOST_STATUS or (run_end is not None and run_end.is_lost)
        _hand_over(
            nodes,
            limit_s=_HAND_OVER_LOST_S if is_lost else _HAND_OVER_S,
            is_in_vain=lambda: signal.SIGTERM in stopping[1:],
            is_clock_stepped=is_clock_stepped,
        )
        if is_clock_stepped:
            leave(status)
        return status
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
        # Python removes its handlers while it shuts down: a late signal would then kill the process.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)


def _spin(nodes: Sequence[Node], is_stopped: Callable[[], bool]) -> None:
    """Run the nodes until a signal comes, one of them is done, or a timer of one fails."""
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
    """Return an EventsExecutor if it exists, otherwise a SingleThreadedExecutor."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def _refuse_changes(parameters: Sequence[Parameter]) -> SetParametersResult:
    """Refuse to set a parameter of a running node, including built-in ones like `use_sim_time`."""
    names = ", ".join(parameter.name for parameter in parameters)
    return SetParametersResult(
        successful=False, reason=f"{names}: not changed; parameters are set when a node starts"
    )


def _hand_over(
    nodes: Sequence[Node], *, limit_s: float, is_in_vain: Callable[[], bool], is_clock_stepped: bool
) -> None:
    """
    Wait, at most `limit_s`, until every reader has what was published to it, or until that `is_in_vain`.

    A publisher with a dead reader does not prevent the wait for the others.

    The middleware waits until a time of the system clock. Where that was stepped, its waits may be endless,
    and Python stands still for as long: a short time must do.
    """
    if is_clock_stepped:
        time.sleep(_HAND_OVER_UNSEEN_S)
        return
    deadline = time.monotonic() + limit_s
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
