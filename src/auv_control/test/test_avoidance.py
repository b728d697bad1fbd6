"""Claims about the obstacle potential of thesis Eqs. (2.19)-(2.20)."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from auv_control.avoidance import obstacle_force, obstacle_potential

COORDINATE = st.floats(-20.0, 20.0)
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE)
OBSTACLES = st.lists(st.tuples(POINT, st.floats(0.3, 5.0)), min_size=1, max_size=4).map(tuple)
GAIN = st.floats(0.1, 20.0)
ORIGIN = (((0.0, 0.0, 0.0), 2.0),)


@given(position=POINT, obstacles=OBSTACLES, gain=GAIN, truncate=st.booleans())
def test_force_is_the_negative_gradient(position, obstacles, gain, truncate):
    ranges = [(math.dist(position[:2], centre[:2]), safety) for centre, safety in obstacles]
    assume(all(r > 0.1 for r, _ in ranges))
    assume(not truncate or all(abs(r - safety) > 1e-3 for r, safety in ranges))
    step = 1e-5
    force = obstacle_force(position, obstacles, gain, truncate=truncate)
    for axis in (0, 1):
        ahead, behind = list(position), list(position)
        ahead[axis] += step
        behind[axis] -= step
        rise = obstacle_potential(tuple(ahead), obstacles, gain, truncate=truncate)
        rise -= obstacle_potential(tuple(behind), obstacles, gain, truncate=truncate)
        steepest = sum(10.0 * gain * safety**2 / r**5 for r, safety in ranges)
        assert force[axis] == pytest.approx(-rise / (2.0 * step), rel=1e-6, abs=1e-4 * (1.0 + steepest))


@given(position=POINT, obstacles=OBSTACLES, gain=GAIN, truncate=st.booleans())
def test_potential_is_never_negative(position, obstacles, gain, truncate):
    assert obstacle_potential(position, obstacles, gain, truncate=truncate) >= -1e-12 * gain


@pytest.mark.parametrize("truncate", [False, True])
def test_potential_and_force_are_zero_at_the_safety_distance(truncate):
    assert obstacle_potential((0.0, 2.0, 9.0), ORIGIN, 3.0, truncate=truncate) == 0.0
    assert obstacle_force((0.0, 2.0, 9.0), ORIGIN, 3.0, truncate=truncate) == (0.0, 0.0)


def test_repels_inside_and_attracts_outside_unless_truncated():
    assert obstacle_force((1.0, 0.0, 0.0), ORIGIN, 1.0, truncate=False) == (6.0, 0.0)
    assert obstacle_force((4.0, 0.0, 0.0), ORIGIN, 1.0, truncate=False) == (-0.375, 0.0)
    assert obstacle_force((1.0, 0.0, 0.0), ORIGIN, 1.0, truncate=True) == (6.0, 0.0)
    assert obstacle_force((4.0, 0.0, 0.0), ORIGIN, 1.0, truncate=True) == (0.0, 0.0)


def test_attraction_far_away_fades_as_2k_over_r():
    north_n, _ = obstacle_force((1000.0, 0.0, 0.0), ORIGIN, 5.0, truncate=False)
    assert north_n == pytest.approx(-2.0 * 5.0 / 1000.0, rel=1e-5)


def test_printed_potential_is_this_one_plus_its_gain():
    # U of (2.19) at r = 1, d = 2: ln(1/4) + 4.
    printed = math.log(0.25) + 4.0
    assert obstacle_potential((1.0, 0.0, 0.0), ORIGIN, 1.0, truncate=False) == pytest.approx(printed - 1.0)


def test_on_the_obstacle_nothing_is_undefined():
    assert obstacle_force((0.0, 0.0, 5.0), ORIGIN, 1.0, truncate=False) == (0.0, 0.0)
    assert obstacle_potential((0.0, 0.0, 5.0), ORIGIN, 1.0, truncate=False) == math.inf
    assert obstacle_potential((0.0, 0.0, 5.0), ORIGIN, 0.0, truncate=False) == 0.0
