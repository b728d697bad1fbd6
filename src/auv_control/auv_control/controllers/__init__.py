"""
Controllers: they compute the command of one vehicle's actuators.

To add one, write one file with ``Params`` and ``Controller(params, period_s)``.  The file's name is its
``kind``.  The class says with ``command`` (``'wrench'`` or ``'velocity'``) what it gives, which must be what
the vehicle's model takes, and with ``follows`` what it is fed:

``follows = 'velocity'``
    The inner loop under a flocking law: ``step(nav, reference) -> Wrench | VelocityCommand``, called once per
    control period with the vehicle's own navigation (`auv_core.messages.VehicleState`) and a
    `VelocityReference`.  One that can run in continuous time has, besides, ``evaluate(attitude, nu, integral,
    reference) -> (tau, growth)``, the wrench at one instant and the rate of an integral of three numbers that
    the caller keeps.

``follows = 'path'`` or ``'region'``
    A law that goes from the `MotionView` of one instant straight to the wrench; with ``'region'`` the view's
    path is None.  It is pure, and what it remembers (parameter estimates, integrals) is a tuple of floats
    that the caller keeps and integrates, so that the sampled agent and the continuous-time runner use the
    same law:

    * ``initial_state(view) -> State``: what it remembers at the start, ``()`` if nothing;
    * ``evaluate(state, view) -> (tau, rate)``: the wrench (N, N m; body FRD) and the rate of `state` per
      second;
    * ``constrained(state) -> State``: `state` brought back to where it is allowed, after each step;
    * ``candidates``: names of its Lyapunov candidates, and ``lyapunov(state, view, kinetic_energy) ->
      tuple`` of their values, one for each name; `kinetic_energy` is the plant's nu^T M nu / 2 as a function
      of nu;
    * ``proof_gap``: one sentence for people on why the printed proof does not cover a run in which V rises;
    * ``shared_candidate``: whether the values are shares, whose sum over the vehicles is the candidate.

    One that follows a region has ``region: Box``, a box around it (m; NED).

    ``Params`` has ``frame`` where the law can be told in which frame the plant lives (see
    `models/four_dof.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from auv_control.references import PathPoint
from auv_core.geometry import Vec3
from auv_core.messages import VehicleState


class VelocityReference(NamedTuple):
    """What a flocking law asks of its vehicle: velocity over ground (m/s; NED) and heading (rad)."""

    velocity: Vec3
    heading_rad: float


@dataclass(frozen=True, slots=True)
class MotionView:
    """
    What one vehicle knows at one instant.

    Own navigation, the path point (None for a law that follows no path), the positions of the neighbours
    (m; NED; as estimated) and the obstacles with their safety distances (m; NED).
    """

    t_s: float
    nav: VehicleState
    path: PathPoint | None
    neighbours: tuple[Vec3, ...] = ()
    obstacles: tuple[tuple[Vec3, float], ...] = ()
