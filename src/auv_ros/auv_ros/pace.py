"""
The time at which a node acts: after its topics are matched, by messages in lock-step, by the steady clock in
real time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rclpy.node import Node

from auv_msgs.msg import FlockStatus
from auv_ros.hearing import Hearing
from auv_ros.joining import Joining
from auv_ros.qos import LATCHED
from auv_ros.rendezvous import Rendezvous
from auv_ros.run_config import RunConfig, TickClock
from auv_ros.run_identity import status_epoch_s
from auv_ros.run_watch import STATUS_TOPIC
from auv_ros.steady_timer import SteadyTimer
from auv_ros.topic import Topic

_WAITS_FOR_RUN = f"the run to begin: {STATUS_TOPIC} of /clock_node"


def tick_clock(run: RunConfig, period_s: float) -> TickClock:
    """Return the clock of a run on this machine's steady clock."""
    return TickClock(run, period_s, time.monotonic, time.time)


class Pace:
    """
    Lets one node begin and act at the right time.

    Parameters
    ----------
    node : Node
        The node that acts.
    ticks : TickClock
        The time of the run.
    topics : iterable of Topic
        Topics that must be matched before the node begins.
    begin : callable
        Called once, with the current tick, when they are matched and scenario time 0 is known.
    act : callable
        Called in every period of real time, with the current tick.
    phase : float
        Phase of the call within a tick, as a fraction of it.
    first_tick : int
        First tick of the node's progress, see `waits_for`.
    leads : bool
        Whether the node itself sets scenario time 0.

    Attributes
    ----------
    ready : bool
        Whether all required nodes hear this one.

    """

    def __init__(
        self,
        node: Node,
        ticks: TickClock,
        topics: Iterable[Topic],
        *,
        begin: Callable[[int], None],
        act: Callable[[int], None],
        phase: float,
        first_tick: int = 0,
        leads: bool = False,
    ) -> None:
        self._node = node
        self._ticks = ticks
        self._begin = begin
        self._act = act
        self._phase = phase
        self._last_tick = first_tick
        self._leads = leads
        self._timer: SteadyTimer | None = None
        self.ready = False
        self._meeting = Rendezvous(node, topics, self._meet)

    def stop(self) -> None:
        """Stop acting in real time."""
        if self._timer is not None:
            self._timer.cancel()

    def missing(self) -> list[str]:
        """Return the full names of the nodes that do not hear this one yet, sorted."""
        return self._meeting.missing()

    def waits_for(self, tick: int, owed: str) -> str:
        """Return as text what the node waits for; `owed` if `tick` is that of the last call."""
        last, self._last_tick = self._last_tick, tick
        if not self.ready:
            return self._meeting.waits_for()
        if not self._ticks.started:
            return _WAITS_FOR_RUN
        return owed if tick == last else ""

    def _meet(self) -> None:
        self.ready = True
        if self._leads:
            self._ticks.begin()
        if self._ticks.started:
            self._start()
        else:
            self._join()

    def _start(self) -> None:
        ticks = self._ticks
        if ticks.lockstep:
            self._begin(0)
            return
        self._begin(max(ticks.tick_now(), 0))
        period_s, first_in_s = ticks.scenario_s(1), ticks.until_phase_s(self._phase)
        self._timer = SteadyTimer(self._node, period_s, lambda: self._act(ticks.tick_now()), first_in_s)

    def _join(self) -> None:
        """Start once the status of the run tells scenario time 0."""
        ticks = self._ticks
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
                self._node.get_logger().warning(
                    f"the system clock is {off_s:+.1f} s off that of the run; this node follows the run's"
                )
            ticks.join(epoch_s, off_s)
            self._start()

        Hearing(self._node).listen_decoded(FlockStatus, STATUS_TOPIC, on_status, LATCHED)
