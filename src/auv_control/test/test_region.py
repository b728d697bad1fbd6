"""Claims about the potentials of the ring and of the layers around vehicles."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.region import (
    Ring,
    distance_to_ring_m,
    layer_gradient,
    layer_potential,
    region_functions,
    region_gradient,
    region_potential,
)

MODERATE = settings(max_examples=100, deadline=None)
POINTS = st.tuples(*[st.floats(-6.0, 6.0)] * 3)
RINGS = st.builds(
    Ring,
    inner_radius_m=st.floats(0.1, 1.0),
    outer_radius_m=st.floats(1.5, 4.0),
    height_m=st.floats(0.2, 4.0),
    centre_ned_m=POINTS,
)
GAINS = st.floats(0.05, 500.0)
LAYERS = st.tuples(st.floats(1.0, 3.0), GAINS, st.floats(0.2, 0.9), GAINS).map(
    lambda numbers: ((numbers[0], numbers[1]), (numbers[2], numbers[3]))
)
STEP_M = 1e-5
THESIS_RING = Ring(0.3, 2.5, 1.0, (10.0, 10.0, 10.0))


def _slope(potential, point):
    """Return the gradient of a potential by central differences."""
    point = np.array(point)
    return [
        (potential(tuple(point + step)) - potential(tuple(point - step))) / (2.0 * STEP_M)
        for step in STEP_M * np.eye(3)
    ]


@MODERATE
@given(RINGS, POINTS, GAINS)
def test_region_gradient_is_that_of_its_potential(ring, point, gain_pm3):
    slope = _slope(lambda p: region_potential(p, ring, gain_pm3), point)
    given_slope = region_gradient(point, ring, gain_pm3)
    # On the boundary the curvature jumps; a central difference across it is off by radius^2 * step.
    jump_m3 = STEP_M * (ring.outer_radius_m**2 + ring.height_m**2)
    np.testing.assert_allclose(given_slope, slope, rtol=1e-5, atol=(1e-4 + jump_m3) * gain_pm3)


def test_on_the_boundary_of_the_ring_the_gradient_is_zero():
    ring = Ring(inner_radius_m=1.0, outer_radius_m=4.0, height_m=1.0, centre_ned_m=(0.0, 0.0, 0.0))
    assert region_gradient((0.0, 4.0, 0.0), ring, 1.0) == (0.0, 0.0, 0.0)


@MODERATE
@given(POINTS, POINTS, LAYERS)
def test_layer_gradient_is_that_of_its_potential(own, other, layers):
    slope = _slope(lambda p: layer_potential(p, other, layers), own)
    scale = sum(gain for _, gain in layers)
    np.testing.assert_allclose(layer_gradient(own, other, layers), slope, rtol=1e-5, atol=1e-4 * scale)


@MODERATE
@given(POINTS, st.tuples(*[st.floats(-0.5, 0.5)] * 3), LAYERS)
def test_action_is_reaction(own, offset, layers):
    other = tuple(np.add(own, offset).tolist())
    there = layer_gradient(other, own, layers)
    np.testing.assert_array_equal(layer_gradient(own, other, layers), np.negative(there))
    assert layer_potential(own, other, layers) == layer_potential(other, own, layers)


@MODERATE
@given(POINTS, POINTS, LAYERS)
def test_layers_push_apart_and_end_at_the_widest(own, other, layers):
    push = np.dot(np.negative(layer_gradient(own, other, layers)), np.subtract(own, other))
    assert push >= 0.0
    if math.dist(own, other) >= layers[0][0]:
        assert layer_gradient(own, other, layers) == (0.0, 0.0, 0.0)
        assert layer_potential(own, other, layers) == 0.0


def test_inner_layer_adds_to_the_outer_one():
    layers = ((1.0, 100.0), (0.5, 500.0))
    # |p| = 0.4 m: s = (0.84, 0.09) m^2, -dP/dx = (100 * 0.84 + 500 * 0.09) * 2 * 0.4
    assert layer_gradient((0.4, 0.0, 0.0), (0.0, 0.0, 0.0), layers)[0] == pytest.approx(-103.2)
    assert layer_potential((0.4, 0.0, 0.0), (0.0, 0.0, 0.0), layers) == pytest.approx(
        0.5 * (100.0 * 0.84**2 + 500.0 * 0.09**2)
    )


@MODERATE
@given(RINGS, POINTS)
def test_region_functions_are_negative_in_the_ring_only(ring, point):
    is_inside = distance_to_ring_m(point, ring) == 0.0
    assert is_inside == (max(region_functions(point, ring)) <= 0.0) or distance_to_ring_m(point, ring) < 1e-9
    if is_inside and max(region_functions(point, ring)) <= 0.0:
        assert region_potential(point, ring, 1.0) == 0.0
        assert region_gradient(point, ring, 1.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("offset", "towards"),
    [
        ((0.1, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((5.0, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, -5.0, 0.0), (0.0, 1.0, 0.0)),
        ((1.0, 0.0, 3.0), (0.0, 0.0, -1.0)),
        ((1.0, 0.0, -3.0), (0.0, 0.0, 1.0)),
    ],
    ids=["out of the hole", "in from the south", "in from the east", "up", "down"],
)
def test_force_points_into_the_ring(offset, towards):
    point = tuple(np.add(THESIS_RING.centre_ned_m, offset).tolist())
    force = np.negative(region_gradient(point, THESIS_RING, 0.1))
    np.testing.assert_allclose(force / np.linalg.norm(force), towards, atol=1e-12)


def test_distance_to_the_ring_by_hand():
    centre = THESIS_RING.centre_ned_m

    def at(*offset):
        return distance_to_ring_m(tuple(np.add(centre, offset).tolist()), THESIS_RING)

    assert at(1.0, 1.0, 0.4) == 0.0
    assert at(0.0, 0.0, 0.0) == pytest.approx(0.3)
    assert at(0.0, 5.5, 0.5) == pytest.approx(3.0)
    assert at(5.5, 0.0, -4.5) == pytest.approx(5.0)


def test_on_the_axis_the_hole_does_not_push():
    assert region_gradient(THESIS_RING.centre_ned_m, THESIS_RING, 0.1) == (0.0, 0.0, 0.0)
    assert region_potential(THESIS_RING.centre_ned_m, THESIS_RING, 0.1) > 0.0
