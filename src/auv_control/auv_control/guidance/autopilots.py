"""
The autopilots of heading, depth and speed as one pure step: from a setpoint to rudder, stern plane and
propeller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from auv_control.guidance import depth, heading, speed
from auv_control.guidance.depth import DepthGains, DepthState, dived
from auv_control.guidance.heading import HeadingGains, steered
from auv_control.guidance.speed import SpeedGains, propelled
from auv_core.compiled import entry, inner
from auv_core.geometry import heading_from_quaternion, pitch_from_quaternion
from auv_core.integrate import State
from auv_core.messages import FinCommand, Numbers
from auv_core.params import param


class AutopilotGains(NamedTuple):
    """`Params` as compiled functions take them."""

    heading: HeadingGains
    depth: DepthGains
    speed: SpeedGains

    @property
    def numbers(self) -> Numbers:
        """All gains, number after number."""
        return (*self.heading, *self.depth, *self.speed)


_DEPTH_FROM = len(HeadingGains._fields)
_SPEED_FROM = _DEPTH_FROM + len(DepthGains._fields)


@dataclass(frozen=True)
class Params:
    """The three autopilots."""

    heading: heading.Params = param("heading autopilot", default=heading.Params())
    depth: depth.Params = param("depth autopilot", default=depth.Params())
    speed: speed.Params = param("speed autopilot", default=speed.Params())

    @property
    def gains(self) -> AutopilotGains:
        """All of these parameters."""
        return AutopilotGains(self.heading.gains, self.depth.gains, self.speed.gains)


class Measured(NamedTuple):
    """
    What the autopilots measure.

    Heading and pitch (rad), the body rates r and q (rad/s), depth (m), speed U and speed along the path, both
    over ground (m/s).
    """

    heading_rad: float
    pitch_rad: float
    yaw_rate_radps: float
    pitch_rate_radps: float
    depth_m: float
    speed_mps: float
    along_mps: float


class Setpoint(NamedTuple):
    """Commanded heading (rad), turn rate (rad/s), depth (m; NED z) and speed along the path (m/s)."""

    heading_rad: float
    turn_rate_radps: float
    depth_m: float
    speed_mps: float


class AutopilotState(NamedTuple):
    """The heading integral (rad s), the state of the depth autopilot, the speed integral (m)."""

    heading_integral_rads: float
    depth: DepthState
    speed_integral_m: float

    @property
    def numbers(self) -> Numbers:
        """All of them, number after number."""
        return (self.heading_integral_rads, *self.depth, self.speed_integral_m)


def initial_state(depth_m: float) -> AutopilotState:
    """Return the state at the start, at a depth (m)."""
    return AutopilotState(0.0, DepthState(depth_m, 0.0, 0.0), 0.0)


@inner
def measured(state: State, along_mps: float) -> Measured:
    """
    Return the measurements in a vehicle's navigation.

    Parameters
    ----------
    state : (13,) tuple
        Position (m; NED), attitude and nu of the vehicle's own navigation.
    along_mps : float
        Speed over ground along the path (m/s).

    """
    attitude = (state[3], state[4], state[5], state[6])
    u, v, w = state[7], state[8], state[9]
    return Measured(
        heading_from_quaternion(attitude),
        pitch_from_quaternion(attitude),
        state[12],
        state[11],
        state[2],
        math.sqrt(u * u + v * v + w * w),
        along_mps,
    )


@inner
def piloted(
    now: Measured, setpoint: Setpoint, state: AutopilotState, period_s: float, gains: AutopilotGains
) -> tuple[FinCommand, AutopilotState]:
    """
    Return rudder, stern plane and propeller of a control period, and the state after it.

    Parameters
    ----------
    now : Measured
        Measurements.
    setpoint : Setpoint
        Commands from guidance.
    state : AutopilotState
        After the last control period; at the start `initial_state`.
    period_s : float
        Control period (s).
    gains : AutopilotGains
        From `Params.gains`.

    """
    rudder, heading_integral = steered(
        setpoint.heading_rad - now.heading_rad,
        setpoint.turn_rate_radps - now.yaw_rate_radps,
        setpoint.turn_rate_radps,
        now.speed_mps,
        state.heading_integral_rads,
        period_s,
        gains.heading,
    )
    dive = dived(
        now.depth_m,
        setpoint.depth_m,
        now.pitch_rad,
        now.pitch_rate_radps,
        now.speed_mps,
        state.depth,
        period_s,
        gains.depth,
    )
    propeller, speed_integral = propelled(
        now.along_mps, setpoint.speed_mps, state.speed_integral_m, period_s, gains.speed
    )
    return (
        FinCommand(rudder, dive.stern_plane_rad, propeller),
        AutopilotState(heading_integral, dive.state, speed_integral),
    )


@entry("TUPLE8(TUPLE13, float64, TUPLE4, TUPLE5, float64, TUPLE32)", allocates=False)
def step_autopilots(
    state: State, along_mps: float, setpoint: Numbers, memory: Numbers, period_s: float, gains: Numbers
) -> Numbers:
    """
    Return the three numbers of the command of `piloted`, then those of its state.

    Parameters
    ----------
    state, along_mps
        As of `measured`.
    setpoint, memory, gains : tuple of float
        The numbers of a `Setpoint`, an `AutopilotState` and `AutopilotGains`.
    period_s : float
        Control period (s).

    """
    fins, after = piloted(
        measured(state, along_mps),
        Setpoint(*setpoint),
        AutopilotState(memory[0], DepthState(memory[1], memory[2], memory[3]), memory[4]),
        period_s,
        AutopilotGains(
            HeadingGains(*gains[:_DEPTH_FROM]),
            DepthGains(*gains[_DEPTH_FROM:_SPEED_FROM]),
            SpeedGains(*gains[_SPEED_FROM:]),
        ),
    )
    depth = after.depth
    return (
        fins.rudder_rad, fins.stern_plane_rad, fins.propeller_rpm, after.heading_integral_rads,
        depth.depth_command_m, depth.depth_integral_ms, depth.pitch_integral_rads, after.speed_integral_m,
    )  # fmt: skip
