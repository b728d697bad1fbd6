"""The task of a single vehicle: a law that computes the wrench directly from its path or region."""

from __future__ import annotations

import math

from auv_control.controllers import MotionLaw, MotionView, VelocityReference
from auv_control.references import PathPoint
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Command, VehicleState, Wrench
from auv_flocking.flock_task import Obstacles
from auv_flocking.flocking import NOTHING_HEARD
from auv_flocking.neighbours.estimates import Estimates, Neighbours
from auv_flocking.trackers import Sensed

_ZERO: Vec3 = (0.0, 0.0, 0.0)


class MotionTask:
    """
    A motion control law and its state.

    After a step: `law_state` (the law's state at the step) and `reference` (velocity and heading of the
    path). A vehicle with this task estimates no flocking centre: `centre` is its position.
    """

    def __init__(self, law: MotionLaw, obstacles: Obstacles, period_s: float) -> None:
        self.law = law
        self._obstacles = obstacles
        self._period_s = period_s
        self._next_state: State | None = None
        self.law_state: State = ()
        self.centre: Vec3 = _ZERO
        self.centre_rate: Vec3 = _ZERO
        self.flock_velocity = NOTHING_HEARD
        self.reference = VelocityReference(_ZERO, 0.0)

    def step(
        self,
        t_s: float,
        nav: VehicleState,
        path: PathPoint | None,
        neighbours: Neighbours,
        sensed: Sensed = (),
        *,
        is_waiting: bool,
    ) -> Command:
        """Return the wrench of one control period; zero while `is_waiting`."""
        view = self.view(t_s, nav, path, Estimates.of(neighbours).positions(), sensed)
        self.centre = nav.position
        self.law_state = self.law.initial_state(view) if self._next_state is None else self._next_state
        if path is not None:
            self.reference = VelocityReference(path.velocity, path.heading_rad)
        if is_waiting:
            return Wrench((0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        tau, rate = self.law.evaluate(self.law_state, view)
        after = tuple([z + self._period_s * dz for z, dz in zip(self.law_state, rate, strict=True)])
        if math.isfinite(sum(tau) + sum(after)):
            self._next_state = self.law.constrained(after)
        return Wrench(tau)

    def shared(self) -> tuple[float, ...]:
        """Return nothing: there is no consensus filter."""
        return ()

    def view(
        self,
        t_s: float,
        nav: VehicleState,
        path: PathPoint | None,
        neighbours: tuple[Vec3, ...],
        sensed: Sensed = (),
    ) -> MotionView:
        """Return the input of the law for other vehicles at `neighbours` (m; NED) and sensed obstacles."""
        found = tuple([(each.position, each.safety_distance_m) for each in sensed])
        return MotionView(t_s, nav, path, neighbours, self._obstacles + found)
