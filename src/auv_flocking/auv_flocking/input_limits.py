"""Limits of the age and the range of an agent's inputs."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.freshness import age_limit_s, why_not_now
from auv_core.messages import VehicleState
from auv_core.params import param
from auv_core.state_checks import LARGEST, checked_state
from auv_flocking.holding import BAD_NAVIGATION, SILENT_MODEM, STALE_NAVIGATION


@dataclass(frozen=True, kw_only=True)
class InputLimits:
    """Limits beyond which an input is not used and the agent gives the safe command."""

    nav_max_age_s: float = param(
        "largest age of the navigation (s); at least two control periods", default=0.5, above=0.0
    )
    inbox_max_age_s: float = param(
        "longest silence of the modem (s), in a fleet of two or more; at least two control periods",
        default=0.5,
        above=0.0,
    )
    position_max_m: float = param(
        "largest coordinate of the own or a neighbour's position (m; NED)",
        default=1e6,
        above=0.0,
        maximum=LARGEST,
    )
    speed_max_mps: float | None = param(
        "largest own or neighbour's speed (m/s); null: ten times that of the fastest vehicle",
        default=None,
        above=0.0,
        maximum=LARGEST,
    )

    @property
    def largest_speed_mps(self) -> float:
        """The largest speed (m/s), given or derived."""
        return LARGEST if self.speed_max_mps is None else self.speed_max_mps


class InputJudge:
    """Decides whether navigation and modem may be used at a tick."""

    def __init__(self, limits: InputLimits, period_s: float) -> None:
        self._period_s = period_s
        self._position_max_m = limits.position_max_m
        self._speed_max_mps = limits.largest_speed_mps
        self._nav_max_age_s = age_limit_s(limits.nav_max_age_s, period_s)
        self._inbox_max_age_s = age_limit_s(limits.inbox_max_age_s, period_s)

    def navigation(self, t_s: float, nav: VehicleState | None) -> tuple[VehicleState | None, str]:
        """Return the navigation at `t_s` (s) and an empty text, or None and why the agent holds."""
        if nav is None:
            return None, f"{STALE_NAVIGATION}: none came"
        words = why_not_now(t_s - nav.tick * self._period_s, self._nav_max_age_s)
        if words:
            return None, f"{STALE_NAVIGATION}: {words}"
        usable, words = checked_state(
            nav, position_max_m=self._position_max_m, speed_max_mps=self._speed_max_mps
        )
        return usable, f"{BAD_NAVIGATION}: {words}" if words else ""

    def modem(self, t_s: float, inbox_tick: int) -> str:
        """Return why the agent holds at `t_s` (s) if the newest inbox is of `tick`, or an empty text."""
        words = why_not_now(t_s - inbox_tick * self._period_s, self._inbox_max_age_s)
        return f"{SILENT_MODEM}: last inbox {words}" if words else ""
