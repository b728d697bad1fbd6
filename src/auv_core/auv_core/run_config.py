"""How a run keeps time: the settings that every node of it shares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from auv_core.params import param


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """Settings of a run, the same for all of its nodes."""

    mode: str = param(
        "lockstep: advance when everybody has answered; realtime: free-run on the wall clock",
        default="realtime",
        choices=("lockstep", "realtime"),
    )
    epoch_s: float = param(
        "ROS time of scenario time 0 (s), for nodes that wait for nobody; 0: when the run says running",
        default=0.0,
    )
    publishers: str = param(
        "whom nodes hear: own, the nodes of this project only; any, also a modem's driver or a navigation",
        default="own",
        choices=("own", "any"),
    )
    recorded: bool = param("whether a recorder must hear everything from the first tick", default=False)

    @property
    def admits_strangers(self) -> bool:
        """Whether nodes hear publishers that are not of this project."""
        return self.publishers == "any"

    @property
    def waits(self) -> bool:
        """Whether nodes wait for each other before they begin."""
        return self.mode == "lockstep" or self.epoch_s == 0.0


class TickClock:
    """
    From ticks to stamps, and from the wall clock to ticks.

    In lock-step a stamp is the tick's scenario time; in real time it is ROS time, and scenario time 0 is the
    epoch, which `start` sets where the configuration does not.
    """

    def __init__(self, run: RunConfig, period_s: float, now_s: Callable[[], float]) -> None:
        self._period_s = period_s
        self._now_s = now_s
        self.lockstep = run.mode == "lockstep"
        self.epoch_s = 0.0 if self.lockstep else run.epoch_s

    @property
    def started(self) -> bool:
        """Whether scenario time 0 is known."""
        return self.lockstep or self.epoch_s != 0.0

    def start(self, epoch_s: float | None = None) -> None:
        """Set the epoch (s, ROS time), to now without one; once set it stays."""
        if not self.started:
            self.epoch_s = self._now_s() if epoch_s is None else epoch_s

    def scenario_s(self, tick: int) -> float:
        """Return the scenario time of a tick (s)."""
        return tick * self._period_s

    def stamp_s(self, tick: int) -> float:
        """Return the ROS time that messages of a tick carry (s)."""
        return self.epoch_s + tick * self._period_s

    def tick_of_stamp(self, stamp_s: float) -> int:
        """Return the tick whose stamp is nearest to `stamp_s`."""
        return round((stamp_s - self.epoch_s) / self._period_s)

    def tick_now(self) -> int:
        """Return the tick that the wall clock is in; negative before the epoch."""
        return int((self._now_s() - self.epoch_s) // self._period_s)
