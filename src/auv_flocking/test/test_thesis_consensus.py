"""Claims about the consensus filter of the flocking centre."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lossy_network import Network, heard_estimate

from auv_core.integrate import rk4_step
from auv_flocking.consensus.thesis import Consensus, Params

MODERATE = settings(max_examples=50, deadline=None)
STILL = (0.0, 0.0, 0.0)
POINTS = st.tuples(*[st.floats(-20.0, 20.0)] * 3)
FLOCKS = st.lists(POINTS, min_size=2, max_size=7)
RATES = st.floats(0.1, 5.0)


def _others(items, index):
    return [*items[:index], *items[index + 1 :]]


def _rate(law, positions, centres):
    """Return the rates of all estimates (n, 3) on a complete graph."""
    return np.array([
        law.derivative(positions[i], centres[i], _others(centres, i), STILL) for i in range(len(positions))
    ])  # fmt: skip


def _system_matrix(law, count):
    """Return d c_dot / d c (n, n) of one axis, column by column."""
    zero = [(0.0, 0.0, 0.0)] * count
    columns = []
    for j in range(count):
        centres = list(zero)
        centres[j] = (1.0, 0.0, 0.0)
        columns.append(_rate(law, zero, centres)[:, 0])
    return np.array(columns).T


@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_the_filter_is_minus_laplacian_plus_identity(count):
    laplacian = -_system_matrix(Consensus(Params(), 4), count) - np.eye(count)
    np.testing.assert_allclose(laplacian.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(laplacian, laplacian.T)
    np.testing.assert_allclose(laplacian, count * np.eye(count) - np.ones((count, count)))


@MODERATE
@given(FLOCKS)
def test_for_vehicles_at_rest_the_mean_of_the_estimates_is_the_centre(positions):
    centres = _settled(positions)
    np.testing.assert_allclose(centres.mean(axis=0), np.mean(positions, axis=0), atol=1e-6)


@MODERATE
@given(FLOCKS)
def test_every_estimate_is_biased_towards_its_own_vehicle_by_one_over_n_plus_one(positions):
    positions = np.array(positions)
    bias = (positions - positions.mean(axis=0)) / (len(positions) + 1)
    np.testing.assert_allclose(_settled(positions) - positions.mean(axis=0), bias, atol=1e-6)


def _settled(positions):
    """Return the estimates (n, 3) after all have stepped together for long."""
    law = Consensus(Params(), 4)
    positions = [tuple(map(float, p)) for p in positions]
    centres = list(positions)
    for _ in range(400):
        centres = [
            law.step(positions[i], centres[i], _others(centres, i), STILL, 0.1) for i in range(len(centres))
        ]
    return np.array(centres)


@MODERATE
@given(POINTS, POINTS, st.lists(POINTS, max_size=5), POINTS, st.floats(0.01, 2.0), RATES, st.booleans())
def test_a_step_is_the_solution_of_the_equation_with_held_inputs(
    own, centre, others, flock, dt_s, rate, follow
):
    law = Consensus(Params(rate_ps=rate, follow_flock=follow), 4)
    exact: Any = centre
    steps = 400

    def rate_of(_t_s, c: Any) -> Any:
        return law.derivative(own, c, others, flock)

    for step in range(steps):
        exact = rk4_step(rate_of, step * dt_s / steps, exact, dt_s / steps)
    np.testing.assert_allclose(law.step(own, centre, others, flock, dt_s), exact, rtol=1e-7, atol=1e-7)


@MODERATE
@given(POINTS, POINTS, st.lists(POINTS, min_size=1, max_size=6), st.floats(1.0, 1e6), RATES)
def test_long_steps_are_stable(own, centre, others, dt_s, rate):
    law = Consensus(Params(rate_ps=rate), 4)
    everything = np.array([own, centre, *others])
    for _ in range(10):
        centre = law.step(own, centre, others, STILL, dt_s)
        assert (np.array(centre) <= everything.max(axis=0) + 1e-9).all()
        assert (np.array(centre) >= everything.min(axis=0) - 1e-9).all()


def test_the_thesis_filter_does_not_look_at_the_flocks_velocity():
    law = Consensus(Params(), 4)
    arguments = ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), [(2.0, 0.0, 0.0)])
    assert law.derivative(*arguments, (5.0, 5.0, 5.0)) == law.derivative(*arguments, STILL) == (3.0, 0.0, 0.0)


def test_following_the_flock_takes_the_lag_away():
    """A vehicle at a constant velocity v: with it the estimate stays right, without it trails by v / k."""
    velocity = (0.1, -0.05, 0.02)

    def error(follow):
        law = Consensus(Params(rate_ps=1.0, follow_flock=follow), 4)
        centre = (0.0, 0.0, 0.0)
        for tick in range(3000):
            own: Any = tuple(0.01 * tick * v for v in velocity)
            centre = law.step(own, centre, [], velocity, 0.01)
        return np.subtract(centre, [0.01 * 3000 * v for v in velocity])

    np.testing.assert_allclose(error(True), 0.0, atol=2e-3)
    np.testing.assert_allclose(error(False), [-v for v in velocity], atol=2e-3)


@MODERATE
@given(POINTS, st.lists(POINTS, max_size=4), POINTS, RATES, st.booleans())
def test_centre_and_advance_are_derivative_and_step(own, others, flock, rate, follow):
    """To the last bit, period after period; the estimate starts at the own position."""
    law = Consensus(Params(rate_ps=rate, follow_flock=follow), 4)
    heard = [heard_estimate(2 + i, STILL, centre, shared=STILL) for i, centre in enumerate(others)]
    centre = own
    for tick in range(5):
        moved = (own[0] + tick, own[1], own[2])
        assert law.centre(moved, heard) == centre
        rate = law.derivative(moved, centre, others, flock)
        assert law.advance(moved, heard, flock, 0.1) == law.shared() == rate
        centre = law.step(moved, centre, others, flock, 0.1)


@pytest.mark.parametrize("follow", [True, False])
def test_a_neighbours_estimate_is_carried_by_its_own_rate_or_by_the_flocks(follow):
    """Over its age of 2 s; the own rate is in the packet only if it is used."""
    for carried_by, shared, rate in (
        ("rate", (0.5, 0.0, -0.5), (0.5, 0.0, -0.5)),
        ("flock", (), (0.0, 0.25, 0.0) if follow else STILL),
    ):
        law = Consensus(Params(follow_flock=follow, carried_by=carried_by), 2)
        assert len(law.shared_fields) == len(shared)
        other = heard_estimate(
            2, STILL, (1.0, 1.0, 1.0), age_s=2.0, flock_velocity=(0.0, 0.25, 0.0), shared=shared
        )
        x, y, z = rate
        ahead = (1.0 + 2.0 * x, 1.0 + 2.0 * y, 1.0 + 2.0 * z)
        assert law.advance(STILL, [other], STILL, 0.1) == (
            law.derivative(STILL, STILL, [ahead], STILL) if carried_by == "rate" else STILL
        )
        assert law.centre(STILL, []) == law.step(STILL, STILL, [ahead], STILL, 0.1)


POSITIONS = [(0.0, 0.0, 10.0), (8.0, -3.0, 12.0), (-6.0, 9.0, 9.0), (3.0, 2.0, 15.0)]


def _late_network(late, **params):
    """Return four vehicles that hear all of each other after `late` steps of 0.05 s."""
    return Network(lambda: Consensus(Params(**params), 4), POSITIONS, step_s=0.05, late=late)


def test_carried_on_with_its_rate_it_is_stable_only_with_fresh_news():
    """k (n - 1) age is 0.15 to 0.75 at first, then 1.5 and more."""
    bias = (np.array(POSITIONS) - np.mean(POSITIONS, axis=0)) / 5.0
    np.testing.assert_allclose(_late_network(1).run(800)[-1], bias, atol=1e-3)
    assert np.abs(_late_network(10).run(800)[-1]).max() > 100.0


def test_carried_on_with_the_flocks_velocity_it_is_stable_with_news_of_any_age():
    bias = (np.array(POSITIONS) - np.mean(POSITIONS, axis=0)) / 5.0
    for late in (10, 100):
        errors = _late_network(late, carried_by="flock").run(2000)
        np.testing.assert_allclose(errors[-1], bias, atol=1e-3)


def test_who_is_believed_beyond_the_reach_is_no_neighbour():
    near = heard_estimate(2, (4.9, 0.0, 0.0), (1.0, 0.0, 0.0), shared=STILL)
    far = heard_estimate(3, (5.0, 0.0, 0.0), (100.0, 0.0, 0.0), shared=STILL)
    estimates = []
    for heard in ([near], [near, far]):
        law = Consensus(Params(reach_m=5.0), 3)
        law.advance(STILL, heard, STILL, 0.1)
        estimates.append(law.centre(STILL, heard))
    assert estimates[0] == estimates[1] != STILL
