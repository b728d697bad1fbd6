"""
Autopilots of heading, depth and speed: from a course to rudder, stern planes and propeller.

The laws are those of `auv_control.guidance.autopilots`, gains for `remus100`. The safe command is a circle: a
vehicle with fins cannot stop, so without navigation it turns with full rudder at a low speed. Neutral and
with its planes amidships it keeps its depth in that circle: `remus100` sinks by 0.02 m a minute.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.controllers import CourseController
from auv_control.courses import Guided
from auv_control.guidance import autopilots
from auv_control.guidance.autopilots import initial_state, step_autopilots
from auv_core.compiled import fastest
from auv_core.integrate import State
from auv_core.messages import FinCommand, Numbers, VehicleState
from auv_core.params import param


@dataclass(frozen=True)
class Params(autopilots.Params):
    """The three autopilots, and the safe command."""

    safe_propeller_rpm: float = param(
        "speed of the propeller in the safe command (rpm)", default=600.0, above=0.0
    )


class Controller(CourseController):
    """Autopilots with their integrals; a flight begins at the depth of the first tick."""

    command = "fins"
    follows = "course"

    def __init__(self, params: Params, period_s: float) -> None:
        self._gains = params.gains.numbers
        self._period_s = period_s
        self._step = fastest(step_autopilots)
        self._memory: Numbers = ()
        self.safe_command = FinCommand(params.heading.rudder_max_rad, 0.0, params.safe_propeller_rpm)

    @property
    def state(self) -> State:
        """Heading integral (rad s), the three numbers of the depth autopilot, speed integral (m)."""
        return self._memory

    def step(self, nav: VehicleState, guided: Guided) -> FinCommand:
        """Return the command of one control period, from the vehicle's own navigation."""
        memory = self._memory or initial_state(nav.position[2]).numbers
        given = self._step(
            nav.numbers, guided.along_mps, tuple(guided.setpoint), memory, self._period_s, self._gains
        )
        self._memory = given[3:]
        return FinCommand(given[0], given[1], given[2])
