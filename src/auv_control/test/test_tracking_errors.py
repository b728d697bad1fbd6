"""Claims about the errors of path-following laws, in the three frames."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_control.controllers import MotionView
from auv_control.references import PathPoint, circle
from auv_control.tracking_errors import ned_force_in_frame, tracking_errors
from auv_core.geometry import quaternion_from_heading
from auv_core.messages import VehicleState

SMALL = st.floats(-5.0, 5.0)
VECTOR = st.tuples(SMALL, SMALL, SMALL)
ANGLE = st.floats(-3.1, 3.1)


def _view(position, heading_rad, nu, path):
    nav = VehicleState(
        0, position, quaternion_from_heading(heading_rad), (nu[0], nu[1], 0.0, 0.0, 0.0, nu[2])
    )
    return MotionView(0.0, nav, path)


def _turn(heading_rad):
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return np.array([[c, s], [-s, c]])


@given(position=VECTOR, heading_rad=ANGLE, nu=VECTOR, place=VECTOR, velocity=VECTOR, course=ANGLE)
def test_errors_are_reference_minus_actual(position, heading_rad, nu, place, velocity, course):
    path = PathPoint(place, velocity, heading_rad=course)
    flat = tracking_errors(_view(position, heading_rad, nu, path), "flat")
    gap = np.subtract(place, position)[:2]
    np.testing.assert_allclose(flat.pose[:2], gap)
    np.testing.assert_allclose(flat.velocity[:2], np.subtract(velocity, nu)[:2])
    assert math.cos(flat.pose[2] - course + heading_rad) == pytest.approx(1.0)
    body = tracking_errors(_view(position, heading_rad, nu, path), "body")
    np.testing.assert_allclose(body.pose[:2], _turn(heading_rad) @ gap, atol=1e-12)
    np.testing.assert_allclose(body.reference[:2], _turn(heading_rad) @ velocity[:2], atol=1e-12)
    np.testing.assert_allclose(body.velocity[:2], np.subtract(body.reference, nu)[:2], atol=1e-12)
    mixed = tracking_errors(_view(position, heading_rad, nu, path), "mixed")
    assert mixed == flat


@given(heading_rad=ANGLE, rate_radps=st.floats(-1.0, 1.0), t_s=st.floats(0.0, 600.0))
def test_reference_rate_is_the_derivative_of_the_reference(heading_rad, rate_radps, t_s):
    path = circle.Reference(circle.Params(depth_m=0.0))
    step_s = 1e-4

    def reference(dt_s):
        view = _view(
            (0.0, 0.0, 0.0), heading_rad + rate_radps * dt_s, (0.0, 0.0, rate_radps), path.at(t_s + dt_s)
        )
        return tracking_errors(view, "body")

    slope = np.subtract(reference(step_s).reference, reference(-step_s).reference) / (2.0 * step_s)
    np.testing.assert_allclose(reference(0.0).reference_rate, slope, atol=1e-9)


@given(force=st.tuples(SMALL, SMALL), heading_rad=ANGLE)
def test_a_ned_force_is_turned_into_the_hull_only_in_the_body_frame(force, heading_rad):
    view = _view((0.0, 0.0, 0.0), heading_rad, (0.0, 0.0, 0.0), None)
    np.testing.assert_allclose(
        ned_force_in_frame(view, force, "body"), _turn(heading_rad) @ force, atol=1e-12
    )
    assert ned_force_in_frame(view, force, "flat") == force
    assert ned_force_in_frame(view, force, "mixed") == force


def test_no_path_is_refused():
    with pytest.raises(ValueError, match="path point"):
        tracking_errors(_view((0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0), None), "body")
