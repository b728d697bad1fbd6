"""Time of a run: the settings that all of its nodes share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from auv_core.params import param

LAUNCHER_NODE = "/_shoal_launcher"
"""Full name of the launcher's node that receives the run's status; hidden from `ros2 node list`."""
LOCKSTEP_EPOCH_S = 1.0
"""Stamp of scenario time 0 in lock-step (s); not 0, since tf2 interprets 0 as "the latest"."""
START_LEAD_S = 0.5
"""How long a real-time run is announced before scenario time 0 (s), so that all nodes begin at tick 0."""
STEP_LIMIT_S = 0.5
"""A wall clock that moves by more than this relative to the steady clock was stepped (s)."""
VEHICLE_PHASE, RELAY_PHASE, AGENT_PHASE = 0.02, 0.2, 0.45
"""Phases within a tick of real time at which nodes act, as fractions: in the order of lock-step."""


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """Settings of a run, the same for all of its nodes."""

    mode: str = param(
        "lockstep: advance when all nodes have answered; realtime: run freely on the steady clock",
        default="realtime",
        choices=("lockstep", "realtime"),
    )
    epoch_s: float = param(
        "ROS time of scenario time 0 (s), for nodes that do not wait for others; 0: when the status says "
        "running",
        default=0.0,
        minimum=0.0,
    )
    publishers: str = param(
        "accepted publishers: own, the nodes of this run only; any, also modem drivers or navigations",
        default="own",
        choices=("own", "any"),
    )
    recorded: bool = param("whether a recorder must receive all messages from the first tick", default=False)

    @property
    def admits_strangers(self) -> bool:
        """Whether nodes accept foreign publishers."""
        return self.publishers == "any"

    @property
    def waits(self) -> bool:
        """Whether nodes wait for each other before they begin."""
        return self.mode == "lockstep" or self.epoch_s == 0.0


class TickClock:
    """
    Converts ticks to stamps, and times of the steady clock to ticks.

    Scenario time 0 has the stamp `epoch_s`. In lock-step that is `LOCKSTEP_EPOCH_S`; in real time it is ROS
    time (s), known from the configuration or once the run begins. The wall clock is read once, when the epoch
    becomes known; a later step of it changes nothing.

    Parameters
    ----------
    run : RunConfig
        Mode, and the epoch if it is given.
    period_s : float
        Control period (s).
    steady_s, wall_s : callable
        The steady clock and the system's clock (s).

    """

    def __init__(
        self, run: RunConfig, period_s: float, steady_s: Callable[[], float], wall_s: Callable[[], float]
    ) -> None:
        self._period_s = period_s
        self._steady_s = steady_s
        self._wall_s = wall_s
        self._began_s = 0.0
        self.lockstep = run.mode == "lockstep"
        self.started = False
        """Whether scenario time 0 is known."""
        self.epoch_s = 0.0
        self.epoch_ns = 0
        """Stamp of scenario time 0 (ns); 0 until it is known."""
        if self.lockstep:
            self._know(LOCKSTEP_EPOCH_S)
        elif run.epoch_s:
            self._start(run.epoch_s)

    def begin(self) -> None:
        """Set scenario time 0 to `START_LEAD_S` from now; a known epoch does not change."""
        if not self.started:
            self._start(round(self._wall_s() + START_LEAD_S, 3))

    def join(self, epoch_s: float, off_s: float = 0.0) -> None:
        """
        Set the epoch of a run; a known epoch does not change.

        `off_s` is the offset of this machine's wall clock from the run's (s). Ticks follow the run's clock.
        """
        if not self.started:
            self._start(round(epoch_s, 6))
            self._began_s += off_s

    def scenario_s(self, tick: int) -> float:
        """Return the scenario time of a tick (s)."""
        return tick * self._period_s

    def stamp_s(self, tick: int) -> float:
        """Return the ROS time of messages of a tick (s); 0 until the epoch is known."""
        return self.epoch_s + tick * self._period_s if self.started else 0.0

    def tick_of_stamp(self, stamp_s: float) -> int:
        """Return the tick whose stamp is nearest to `stamp_s`."""
        return round((stamp_s - self.epoch_s) / self._period_s)

    def tick_now(self) -> int:
        """Return the current tick of the steady clock; negative before the epoch."""
        return int(self._scenario_now_s() // self._period_s)

    def tick_now_or(self, tick: int) -> int:
        """Return the current tick of the steady clock, or the given one until the epoch is known."""
        return self.tick_now() if self.started else tick

    def until_phase_s(self, phase: float) -> float:
        """Return the time until the given phase of the current or the next tick (s)."""
        return (phase - self._scenario_now_s() / self._period_s) % 1.0 * self._period_s

    def _start(self, epoch_s: float) -> None:
        self._know(epoch_s)
        self._began_s = self._steady_s() + (epoch_s - self._wall_s())

    def _know(self, epoch_s: float) -> None:
        self.started, self.epoch_s = True, epoch_s
        self.epoch_ns = round(epoch_s * 1e6) * 1000  # an epoch is of whole microseconds

    def _scenario_now_s(self) -> float:
        return self._steady_s() - self._began_s


class WallWatch:
    """Detects steps of the wall clock by a time service or a user."""

    def __init__(self, steady_s: Callable[[], float], wall_s: Callable[[], float]) -> None:
        self._lead_s: Callable[[], float] = lambda: wall_s() - steady_s()
        self._known_s = self._lead_s()

    def warning(self) -> str:
        """Return one line if the wall clock was stepped since the last call, otherwise ''."""
        step_s = self._lead_s() - self._known_s
        self._known_s += step_s
        if abs(step_s) <= STEP_LIMIT_S:
            return ""
        return f"the system clock was stepped by {step_s:+.1f} s; the run goes on by the steady clock"
