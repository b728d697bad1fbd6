"""
Courses: what tells a vehicle with fins where to go: heading, depth and speed.

To add one, write one file with ``Params`` and ``Course(params, period_s)``, a `CourseLaw`. The file's name is
its ``kind``.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from auv_control.guidance.autopilots import Setpoint
from auv_control.guidance.feasibility import Turning
from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Box
from auv_core.messages import VehicleState
from auv_core.params import Section


class Guided(NamedTuple):
    """
    What a course asks of the autopilots at a tick.

    setpoint : heading (rad), turn rate (rad/s), depth (m; NED z) and speed (m/s).
    along_mps : the measured speed that the commanded one is compared with (m/s).
    cross_track_m : distance to starboard of the path (m); NaN without a path.
    """

    setpoint: Setpoint
    along_mps: float
    cross_track_m: float = math.nan


class CourseLaw(Protocol):
    """A course: it is stepped once per control period and keeps its own state."""

    def step(self, t_s: float, nav: VehicleState) -> Guided:
        """Return what it asks at a time (s), from the vehicle's own navigation."""

    def check(self, vehicle: Turning, current_mps: float) -> None:
        """
        Check that a vehicle can follow it in any current of a speed (m/s).

        Raises
        ------
        ValueError
            With the parameter, the value and what is allowed.

        """

    def reach(self, duration_s: float) -> Box | None:
        """Return a box around the path for that time (m; NED), None if it has no path."""


def make_course(section: Section, period_s: float) -> CourseLaw:
    """Return the course of a section, for a control period (s)."""
    law: CourseLaw = fulfilled(
        class_of(__name__, section.kind, "Course")(section.params, period_s), CourseLaw
    )
    return law
