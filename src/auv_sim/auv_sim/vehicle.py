"""One simulated vehicle: its true motion, with actuators and current."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Command, Numbers, VehicleState, command_numbers
from auv_core.models import HULL, Actuator, VehicleModel, make_model
from auv_core.params import Section, param, same
from auv_core.run_settings import RunSettings
from auv_core.thrusters import ThrusterFault
from auv_sim.currents import make_current, steady
from auv_sim.navigation import exact, make_navigation

MODELS = "auv_core.models"
NAVIGATION = "auv_sim.navigation"
CURRENTS = "auv_sim.currents"
EXACT = Section("exact", exact.Params())
STEADY = Section("steady", steady.Params())

_MOST_SUBSTEPS = 1_000_000


@dataclass(frozen=True, kw_only=True)
class VehicleConfig:
    """Configuration of one simulated vehicle."""

    vehicle_id: str = param("name of the vehicle, also its namespace")
    model: Section = param("equations of motion and their numbers", plugins=MODELS)
    position_ned_m: Vec3 = param("start position (m; NED)")
    heading_rad: float = param(
        "start heading (rad, from north towards east)", default=0.0, minimum=-7.0, maximum=7.0
    )
    speed_mps: float = param(
        "start speed, ahead and over ground (m/s)", default=0.0, minimum=0.0, maximum=10.0
    )
    current_ned_mps: Vec3 = param(
        "mean velocity of the water (m/s; NED)", default=(0.0, 0.0, 0.0), minimum=-5.0, maximum=5.0
    )
    current: Section = param("how the velocity of the water varies", default=STEADY, plugins=CURRENTS)
    dt_s: float = same(RunSettings, "dt_s")
    period_s: float = same(RunSettings, "period_s")
    address: int = param("acoustic address of this vehicle, from 1", default=1, minimum=1, maximum=254)
    seed: int = same(RunSettings, "seed")
    navigation: Section = param("errors of the vehicle's own navigation", default=EXACT, plugins=NAVIGATION)
    fault: ThrusterFault = param("fault of a thruster", default=ThrusterFault())
    propeller_limit_rpm: float | None = param(
        "largest speed that a fault leaves to the propeller, of which the vehicle's computer does not know "
        "(rpm); null: no fault",
        default=None,
        minimum=0.0,
    )
    fails_at_s: float | None = same(RunSettings, "fails_at_s")
    command_max_age_s: float = param(
        "age of a command above which the actuators stop (s); at least two control periods",
        default=0.5,
        above=0.0,
    )

    def __post_init__(self) -> None:
        substeps(self.period_s, self.dt_s)


def substeps(period_s: float, dt_s: float) -> int:
    """
    Return the number of physics steps in a control period.

    Raises
    ------
    ValueError
        Unless the period is a whole number of steps (to 1e-9 of a step), at most a million.

    """
    ratio = period_s / dt_s
    count = round(min(ratio, _MOST_SUBSTEPS))
    if count < 1 or abs(ratio - count) > 1e-9:
        raise ValueError(
            f"period_s: {period_s!r} is not allowed; allowed: a whole multiple of dt_s = {dt_s!r}"
        )
    return count


class DivergedError(RuntimeError):
    """Raised for a motion without a finite solution; the message is one line for the user."""


def check_finite(state: State, vehicle_id: str, t_s: float) -> None:
    """Raise `DivergedError` unless all numbers of `state`, reached after `t_s`, are finite."""
    if not math.isfinite(sum(state)):
        raise DivergedError(
            f"{vehicle_id}: its motion has no finite solution after t = {t_s:.2f} s; "
            "a model or a gain is unstable"
        )


class Vehicle:
    """
    The true vehicle. `step` advances it by one control period with the command held; `state` is the truth at
    the latest tick, `nav` the output of its own navigation, and `navigation` the navigation itself. `command`
    is the kind of command that it takes.
    """

    def __init__(self, config: VehicleConfig) -> None:
        self._model: VehicleModel = make_model(config.model)
        self._current = make_current(
            config.current, config.current_ned_mps, config.seed, config.address, config.period_s
        )
        self._dt_s = config.dt_s
        self._substeps = substeps(config.period_s, config.dt_s)
        self._tick = 0
        self._state: State = self._model.initial_state(
            config.position_ned_m, config.heading_rad, config.speed_mps
        )
        self.state = self._record()
        self._name = config.vehicle_id
        self._fails_at_s = math.inf if config.fails_at_s is None else config.fails_at_s
        self._has_computer = True
        self._period_s = config.period_s
        self.navigation = make_navigation(config.navigation, config.seed, config.address, config.period_s)
        self._fault = config.fault
        self._propeller_limit_rpm = config.propeller_limit_rpm
        self.command = self._model.command
        self.nav: VehicleState = self.navigation.measured(self.state)

    @property
    def command_size(self) -> int:
        """Count of the numbers of a command."""
        return len(self._model.resting_command())

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """The actuators that have a state."""
        return self._model.actuators

    @property
    def actuator_outputs(self) -> Numbers:
        """Outputs of `actuators` at the latest tick, each in its unit."""
        return self._state[HULL:]

    def restore(self, state: VehicleState) -> None:
        """Set the vehicle to `state`, at its tick, with the outputs of its actuators at zero."""
        self._tick = state.tick
        self._state = (*state.position, *state.attitude, *state.nu, *(0.0 for _ in self._model.actuators))
        self.state = self._record()

    def lose_computer(self) -> None:
        """From now on the hull is one without a computer; without a command it drifts."""
        self._model = self._model.adrift()
        self._has_computer = False

    def step(self, command: Command | None) -> VehicleState:
        """
        Return the state one control period later; without a command the actuators rest and the hull drifts.
        After the failure of the vehicle's computer no command counts.

        Raises
        ------
        DivergedError
            If the motion has no finite solution.

        """
        if self._has_computer and self._fails_at_s <= self._tick * self._period_s:
            self.lose_computer()
        if not self._has_computer:
            command = None
        values = self._model.resting_command() if command is None else command_numbers(command)
        given = self._model.limited_command(values)
        if self._fault.has_begun(self._tick * self._period_s):
            given = _without(given, self._fault.thruster)
        if self._propeller_limit_rpm is not None:
            rudder_rad, stern_plane_rad, propeller_rpm = given
            given = (rudder_rad, stern_plane_rad, min(propeller_rpm, self._propeller_limit_rpm))
        self._state = self._model.step(
            self._state, given, self._current.at(self._tick), self._dt_s, self._substeps
        )
        check_finite(self._state, self._name, self._tick * self._period_s)
        self._tick += 1
        self.state = state = self._record()
        self.nav = self.navigation.measured(state)
        return state

    def _record(self) -> VehicleState:
        s = self._state
        return VehicleState(
            self._tick,
            (s[0], s[1], s[2]),
            (s[3], s[4], s[5], s[6]),
            (s[7], s[8], s[9], s[10], s[11], s[12]),
            is_bounded=True,
        )


def _without(forces_n: Numbers, thruster: int) -> Numbers:
    """Return the forces with that of a thruster, counted from 1, at zero."""
    return (*forces_n[: thruster - 1], 0.0, *forces_n[thruster:])
