"""Claims about rotations and vectors, on random attitudes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from auv_core.geometry import (
    body_to_ned,
    distance,
    heading_from_quaternion,
    limited,
    ned_to_body,
    quaternion_from_heading,
    quaternion_product,
)

MODERATE = settings(max_examples=80, deadline=None)
COMPONENT = st.floats(-100.0, 100.0)
VECTORS = st.tuples(COMPONENT, COMPONENT, COMPONENT)
ANGLES = st.floats(-math.pi, math.pi)
QUATERNIONS = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: math.hypot(*q) > 1e-3)
    .map(lambda q: tuple(x / math.hypot(*q) for x in q))
)


def _rotation(q):
    return Rotation.from_quat([*q[1:], q[0]])


@MODERATE
@given(QUATERNIONS, VECTORS)
def test_rotations_keep_length(q, v):
    assert math.hypot(*body_to_ned(q, v)) == pytest.approx(math.hypot(*v), rel=1e-12, abs=1e-12)


@MODERATE
@given(QUATERNIONS, VECTORS)
def test_ned_to_body_is_the_inverse(q, v):
    assert ned_to_body(q, body_to_ned(q, v)) == pytest.approx(v, abs=1e-10)


@MODERATE
@given(QUATERNIONS, VECTORS)
def test_body_to_ned_is_the_rotation_of_its_quaternion(q, v):
    np.testing.assert_allclose(body_to_ned(q, v), _rotation(q).apply(v), atol=1e-10)


@MODERATE
@given(QUATERNIONS, QUATERNIONS, VECTORS)
def test_quaternion_product_rotates_by_the_second_first(a, b, v):
    np.testing.assert_allclose(
        body_to_ned(quaternion_product(a, b), v), body_to_ned(a, body_to_ned(b, v)), atol=1e-9
    )


@MODERATE
@given(QUATERNIONS, QUATERNIONS)
def test_quaternion_product_keeps_unit_length(a, b):
    assert math.hypot(*quaternion_product(a, b)) == pytest.approx(1.0, abs=1e-12)


@MODERATE
@given(ANGLES)
def test_heading_survives_the_round_trip(heading_rad):
    back_rad = heading_from_quaternion(quaternion_from_heading(heading_rad))
    assert math.remainder(back_rad - heading_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_heading_turns_from_north_to_east():
    assert body_to_ned(quaternion_from_heading(math.pi / 2.0), (1.0, 0.0, 0.0)) == pytest.approx(
        (0.0, 1.0, 0.0)
    )


@MODERATE
@given(ANGLES, st.floats(-1.5, 1.5), ANGLES)
def test_heading_is_the_yaw_of_the_euler_angles(yaw_rad, pitch_rad, roll_rad):
    x, y, z, w = Rotation.from_euler("ZYX", [yaw_rad, pitch_rad, roll_rad]).as_quat()
    error_rad = heading_from_quaternion((w, x, y, z)) - yaw_rad
    assert math.remainder(error_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


@MODERATE
@given(VECTORS, VECTORS)
def test_distance_is_symmetric_and_euclidean(a, b):
    assert distance(a, b) == distance(b, a) == pytest.approx(math.dist(a, b))


@MODERATE
@given(VECTORS, st.floats(1e-3, 1e3))
def test_limited_keeps_direction_and_holds_the_limit(v, length):
    short = limited(v, length)
    assert math.hypot(*short) <= length * (1.0 + 1e-12)
    assert np.linalg.norm(np.cross(short, v)) <= 1e-9 * (1.0 + math.hypot(*v) ** 2)
    assert np.dot(short, v) >= 0.0
    if math.hypot(*v) <= length * (1.0 - 1e-12):
        assert short == v
