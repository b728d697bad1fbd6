"""The task of a vehicle with fins that follows a course: autopilots under guidance."""

from __future__ import annotations

import math

from auv_control.controllers import CourseController, VelocityReference
from auv_control.courses import CourseLaw
from auv_core.geometry import Vec3
from auv_core.messages import Command, VehicleState
from auv_flocking.flocking import NOTHING_HEARD

HEADING, DEPTH, SPEED, CROSS_TRACK = 0, 2, 3, 4
"""Columns of `law_state`."""
_ZERO: Vec3 = (0.0, 0.0, 0.0)


class CourseTask:
    """
    A course and the autopilots under it.

    After a step: `law_state` (heading (rad), turn rate (rad/s), depth (m) and speed (m/s) that the course
    asks for, cross-track error (m; 0 without a path), then the state of the autopilots) and `reference`
    (velocity and heading that the course asks for). A vehicle with this task estimates no flocking centre:
    `centre` is its position.
    """

    def __init__(self, course: CourseLaw, controller: CourseController) -> None:
        self._course = course
        self._controller = controller
        self.safe_command = controller.safe_command
        self.law_state: tuple[float, ...] = ()
        self.centre: Vec3 = _ZERO
        self.centre_rate: Vec3 = _ZERO
        self.flock_velocity = NOTHING_HEARD
        self.reference = VelocityReference(_ZERO, 0.0)

    def step(self, t_s: float, nav: VehicleState) -> Command:
        """Return the command of one control period."""
        guided = self._course.step(t_s, nav)
        heading_rad, _, _, speed_mps = guided.setpoint
        command = self._controller.step(nav, guided)
        beside_m = 0.0 if math.isnan(guided.cross_track_m) else guided.cross_track_m
        self.law_state = (*guided.setpoint, beside_m, *self._controller.state)
        velocity = (speed_mps * math.cos(heading_rad), speed_mps * math.sin(heading_rad), 0.0)
        self.reference = VelocityReference(velocity, heading_rad)
        self.centre = nav.position
        return command

    def shared(self) -> tuple[float, ...]:
        """Return nothing: there is no consensus filter."""
        return ()
