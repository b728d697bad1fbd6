"""
The feedback gains of a path-following law, so that laws are compared at equal stiffness.

On the path, a small error e along one axis changes the force by k_p e + k_v e', whatever the form of the law.
k_p is its stiffness (N/m), k_v its damping (N s/m); integral states and estimates rest. The vehicle has gone
round once. A stiffer law has a smaller error under any disturbance: laws with other gains show their gains.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from auv_control.controllers import MotionLaw, MotionView
from auv_control.references.circle import Params as CircleParams
from auv_control.references.circle import Reference
from auv_core.messages import VehicleState

_STEP = 1e-6
_NORTHWARDS = (1.0, 0.0, 0.0, 0.0)


class Gains(NamedTuple):
    """Stiffness (N/m) and damping (N s/m), each along surge and sway."""

    stiffness_npm: tuple[float, float]
    damping_nspm: tuple[float, float]


def feedback_gains(law: MotionLaw) -> Gains:
    """Return the gains of a law on the circle of the comparison, by central differences of its forces."""
    stiffness = (_slope(law, 0, position=True), _slope(law, 1, position=True))
    damping = (_slope(law, 0, position=False), _slope(law, 1, position=False))
    return Gains(stiffness, damping)


def _slope(law: MotionLaw, axis: int, *, position: bool) -> float:
    """Return minus the derivative of the force along an axis by position (m) or velocity (m/s)."""
    ahead, behind = (_force_n(law, axis, step, position=position) for step in (_STEP, -_STEP))
    return (behind - ahead) / (2.0 * _STEP)


def _force_n(law: MotionLaw, axis: int, step: float, *, position: bool) -> float:
    view = _view(axis, step, position=position)
    wrench, _ = law.evaluate(law.initial_state(_view(axis, 0.0, position=position)), view)
    return wrench[axis]


def _view(axis: int, step: float, *, position: bool) -> MotionView:
    """Return a vehicle on the path, after one round, that is off by `step` along one axis (m or m/s)."""
    circle: Any = Reference(CircleParams(radius_m=10.0, rate_radps=0.01, depth_m=0.0, heading_rad=0.0))
    path = circle.at(circle.period_s)
    place, speed = list(path.position), [*path.velocity, 0.0, 0.0, 0.0]
    if position:
        place[axis] += step
    else:
        speed[axis] += step
    nav = VehicleState(0, (place[0], place[1], place[2]), _NORTHWARDS, tuple(speed))
    return MotionView(circle.period_s, nav, path)
