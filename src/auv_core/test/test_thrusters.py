"""Claims about thrusters: their matrix, their limits, what is left after a loss, and the dead zone."""

import math

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from auv_core.params import ConfigError, load
from auv_core.plugins import plugin_places
from auv_core.thrusters import Thrusters, axis_maxima, delivered_n

X, Y, Z, K, M, N = range(6)
UNITS = {"positions_m": [1.0, 0.0, 0.0], "directions": [1.0, 0.0, 0.0]}
FORCES = {"max_forward_n": [10.0], "max_backward_n": [5.0]}


def thrusters_of(preset, **changes):
    (folder,) = plugin_places("auv_core.models")
    raw = yaml.safe_load((folder / "presets" / f"{preset}.yaml").read_text(encoding="utf-8"))
    return load(Thrusters, {**raw["params"]["thrusters"], **changes}, "thrusters")


ODIN = thrusters_of("odin", max_forward_n=[100.0], max_backward_n=[100.0])
BLUEROV2 = thrusters_of("bluerov2_heavy")


def maxima(thrusters, *lost):
    return axis_maxima(thrusters.matrix(lost), thrusters.lowest_n, thrusters.highest_n)


def condition(thrusters, *lost):
    sizes = np.linalg.svd(thrusters.matrix(lost))[1]
    return sizes[0] / sizes[-1]


def rank(thrusters, *lost):
    return np.linalg.matrix_rank(thrusters.matrix(lost), tol=1e-6)


def test_odins_matrix_has_the_published_rows():
    s, l1, l2 = math.sqrt(0.5), 0.381, 0.508
    published: list[list[float]] = [
        [s, -s, -s, s, 0, 0, 0, 0],
        [s, s, -s, -s, 0, 0, 0, 0],
        [0, 0, 0, 0, -1, -1, -1, -1],
        [0, 0, 0, 0, l1 * s, l1 * s, -l1 * s, -l1 * s],
        [0, 0, 0, 0, l1 * s, -l1 * s, -l1 * s, l1 * s],
        [l2, -l2, l2, -l2, 0, 0, 0, 0],
    ]
    np.testing.assert_allclose(ODIN.matrix(), published, atol=1e-6)


@pytest.mark.parametrize(("thrusters", "expected"), [(ODIN, 3.71), (BLUEROV2, 8.36)])
def test_intact_vehicles_have_all_six_degrees_of_freedom(thrusters, expected):
    assert rank(thrusters) == 6
    assert condition(thrusters) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("number", range(1, 9))
def test_no_single_loss_costs_a_degree_of_freedom(number):
    assert rank(ODIN, number) == rank(BLUEROV2, number) == 6
    assert condition(ODIN, number) == pytest.approx(3.71 if number <= 4 else 5.66, abs=0.01)


def test_two_losses_cost_one_only_in_the_same_group_of_four():
    pairs = [(a, b) for a in range(1, 9) for b in range(a + 1, 9)]
    same = [pair for pair in pairs if (pair[0] <= 4) == (pair[1] <= 4)]
    assert len(same) == 12
    for thrusters in (ODIN, BLUEROV2):
        assert [pair for pair in pairs if rank(thrusters, *pair) == 5] == same


@pytest.mark.parametrize(
    ("thrusters", "lost", "expected"),
    [
        (ODIN, (), {X: 282.8, Y: 282.8, Z: 400.0, K: 107.8, M: 107.8, N: 203.2}),
        (ODIN, (2,), {X: 141.4, Y: 141.4, Z: 400.0, K: 107.8, M: 107.8, N: 101.6}),
        (ODIN, (7,), {X: 282.8, Y: 282.8, Z: 200.0, K: 53.9, M: 53.9, N: 203.2}),
        (BLUEROV2, (), {X: 145.7, Y: 113.7, Z: 160.8, K: 35.1, M: 19.3, N: 30.4}),
        (BLUEROV2, (1,), {X: 72.8, Y: 56.9, N: 15.2}),
        (BLUEROV2, (5,), {Z: 80.4, K: 17.5, M: 9.6}),
        (ODIN, (1, 2), {X: 0.0, Y: 141.4, N: 0.0}),
        (ODIN, tuple(range(1, 9)), dict.fromkeys(range(6), 0.0)),
    ],
)
def test_largest_pure_forces_and_moments(thrusters, lost, expected):
    positive = maxima(thrusters, *lost)[:, 0]
    assert {axis: positive[axis] for axis in expected} == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize("thrusters", [ODIN, BLUEROV2])
@pytest.mark.parametrize("lost", [(), (1,), (5,), (3, 6), (5, 6)])
def test_the_largest_pure_forces_are_those_of_a_linear_program(thrusters, lost):
    found, limits = maxima(thrusters, *lost), list(zip(thrusters.lowest_n, thrusters.highest_n, strict=True))
    for axis in range(6):
        for sense, sign in enumerate((1.0, -1.0)):
            column = -sign * np.eye(6)[:, [axis]]
            best = linprog(
                [0.0] * 8 + [-1.0],
                A_eq=np.hstack([thrusters.matrix(lost), column]),
                b_eq=np.zeros(6),
                bounds=[*limits, (0, None)],
            )
            assert found[axis, sense] == pytest.approx(-best.fun, abs=1e-6)


def test_six_horizontal_and_vertical_thrusters_cannot_pitch():
    """With two vertical thrusters, as the standard BlueROV2 has, there is no pure surge: it pitches."""
    few = thrusters_of(
        "bluerov2_heavy",
        positions_m=[*BLUEROV2.positions_m[:12], 0.0, 0.12, 0.0, 0.0, -0.12, 0.0],
        directions=[*BLUEROV2.directions[:12], *[0.0, 0.0, -1.0] * 2],
    )
    assert rank(few) == 5
    found = maxima(few)
    assert found[M].tolist() == found[X].tolist() == [0.0, 0.0]
    assert found[Z] == pytest.approx([80.4, 103.0])


@pytest.mark.parametrize(
    ("lost", "axis", "missed", "size"),
    [(1, X, 0.25, 0.40), (1, N, 0.25, 0.55), (5, Z, 0.25, 0.27), (5, K, 0.25, 1.0)],
)
def test_a_loss_that_is_not_known_misses_a_quarter_and_couples_the_axes(lost, axis, missed, size):
    """The inverse of the intact matrix on ODIN less a thruster; `size` mixes N and N m."""
    error = np.eye(6) - ODIN.matrix((lost,)) @ np.linalg.pinv(ODIN.matrix())
    assert error[axis, axis] == pytest.approx(missed, abs=1e-6)
    assert np.linalg.norm(error[:, axis]) == pytest.approx(size, abs=0.01)


dead_zones = st.floats(0.0, 0.5)
demands = st.floats(-200.0, 200.0)


@given(demands, dead_zones)
def test_a_driver_that_knows_the_dead_zone_delivers_the_demand_within_the_limits(demand_n, zone):
    assert delivered_n(demand_n, -40.2, 51.5, zone, zone) == min(max(demand_n, -40.2), 51.5)


@given(demands, dead_zones, dead_zones)
def test_a_wrong_dead_zone_costs_force_only_if_it_is_assumed_too_small(demand_n, zone, assumed):
    wanted_n = min(max(demand_n, -40.2), 51.5)
    force_n = delivered_n(demand_n, -40.2, 51.5, zone, assumed)
    assert -40.2 - 1e-9 <= force_n <= 51.5 + 1e-9
    assert force_n * wanted_n >= 0.0
    if assumed < zone:
        assert abs(force_n) <= abs(wanted_n) + 1e-9
    else:
        assert abs(force_n) >= abs(wanted_n) - 1e-9


def test_inside_the_dead_zone_there_is_no_force():
    assert delivered_n(131.0 * 0.04**2, -131.0, 131.0, 0.05, 0.0) == 0.0
    assert delivered_n(131.0 * 0.5**2, -131.0, 131.0, 0.05, 0.0) == pytest.approx(131.0 * (0.45 / 0.95) ** 2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"positions_m": [1.0]}, "positions_m: 1 numbers are not allowed; allowed: three for each thruster"),
        ({"directions": [1.0, 0.0]}, "directions: 2 numbers are not allowed; allowed: 3, three for each"),
        ({"directions": [1.0, 1.0, 0.0]}, r"directions: a vector of length 1\.414 \(thruster 1\) is not all"),
        ({"max_forward_n": [1.0, 1.0]}, "max_forward_n: 2 numbers are not allowed; allowed: one, or one for"),
        ({"max_backward_n": []}, "max_backward_n: 0 numbers are not allowed; allowed: one, or one for each"),
        (
            {"max_forward_n": [0.0]},
            r"max_forward_n\[0\]: 0\.0 is not allowed; allowed: a finite number above 0",
        ),
    ],
)
def test_numbers_that_do_not_fit_are_refused_in_one_line(changes, message):
    with pytest.raises(ConfigError, match=rf"^thrusters\.{message}"):
        load(Thrusters, {**UNITS, **FORCES, **changes}, "thrusters")
