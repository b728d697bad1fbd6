"""Claims about the projection into half-spaces."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_flocking.flocking import _half_spaces as projection

MODERATE = settings(max_examples=80, deadline=None)
SPEEDS = st.floats(-2.0, 2.0)
VELOCITIES = st.tuples(SPEEDS, SPEEDS, SPEEDS)


def into_half_spaces(velocity, half_spaces):
    rows = np.array([(*normal, bound_mps) for normal, bound_mps in half_spaces]).reshape(-1, 4)
    return projection.into_half_spaces(velocity, rows)


def _unit(vector):
    length = math.hypot(*vector)
    return tuple(x / length for x in vector)


NORMALS = VELOCITIES.filter(lambda v: math.hypot(*v) > 0.1).map(_unit)


def _along(normal, velocity):
    return sum(n * v for n, v in zip(normal, velocity, strict=True))


def test_allowed_velocity_comes_back_as_it_is():
    wanted = (0.1, -0.2, 0.3)
    assert into_half_spaces(wanted, [((1.0, 0.0, 0.0), 0.1), ((0.0, 0.0, 1.0), -5.0)]) == wanted
    assert into_half_spaces(wanted, []) == wanted


@MODERATE
@given(velocity=VELOCITIES, normal=NORMALS, bound_mps=SPEEDS)
def test_one_plane_is_met_by_the_nearest_velocity(velocity, normal, bound_mps):
    result = into_half_spaces(velocity, [(normal, bound_mps)])
    short_mps = max(bound_mps - _along(normal, velocity), 0.0)
    assert result == pytest.approx(
        tuple(v + short_mps * n for v, n in zip(velocity, normal, strict=True)), abs=1e-9
    )
    assert _along(normal, result) >= bound_mps - 1e-9


@MODERATE
@given(velocity=VELOCITIES, normals=st.tuples(NORMALS, NORMALS), slack_mps=st.floats(0.0, 1.0))
def test_planes_that_do_not_oppose_are_met_within_the_passes(velocity, normals, slack_mps):
    first, second = normals
    cosine = _along(first, second)
    half_spaces = [(first, -slack_mps), (second, -slack_mps)]
    result = into_half_spaces(velocity, half_spaces)
    speed_mps = math.hypot(*velocity)
    left_mps = 1e-9 + speed_mps * abs(cosine) ** 14 if cosine < 0.0 else 1e-9
    assert all(_along(n, result) >= b - left_mps for n, b in half_spaces)


def test_contradicting_bounds_end_in_a_finite_compromise():
    walls = [((1.0, 0.0, 0.0), 1.0), ((-1.0, 0.0, 0.0), 1.0)]
    result = into_half_spaces((0.0, 0.5, 0.0), walls)
    assert math.hypot(*result) < 2.0
    assert result[1] == 0.5


@pytest.mark.parametrize(("nearest_m", "most_mps"), [(1.3, 0.01), (1.0, 0.12)])
def test_seven_bounds_at_once_are_met_but_for_what_the_page_says(nearest_m, most_mps):
    """Neighbours all around up to 6 m away, none or some within the barrier's 1.3 m; 3000 random cases."""
    rng = np.random.default_rng(1)
    worst_mps = 0.0
    for _ in range(3000):
        normals = rng.normal(size=(7, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        bounds_mps = -0.25 * (rng.uniform(nearest_m, 6.0, 7) - 1.3)
        wanted = rng.normal(size=3)
        wanted *= 0.25 / np.linalg.norm(wanted)
        half_spaces = [(tuple(n), b) for n, b in zip(normals.tolist(), bounds_mps.tolist(), strict=True)]
        left_mps = bounds_mps - normals @ into_half_spaces(tuple(wanted.tolist()), half_spaces)
        worst_mps = max(worst_mps, left_mps.max())
    assert 0.0 < worst_mps < most_mps
