"""Claims about the neighbour filters."""

import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.linalg import expm

from auv_flocking.neighbours.motion import process_noise, transition_matrix
from auv_flocking.neighbours.table import NeighbourConfig, NeighbourTable
from auv_flocking.report import Report

CONFIG = NeighbourConfig(acceleration_psd=4e-3, position_std_m=0.05, velocity_std_mps=0.02, timeout_s=30.0)
R = np.diag([CONFIG.position_std_m**2] * 3 + [CONFIG.velocity_std_mps**2] * 3)
MODERATE = settings(max_examples=30, deadline=None)


def _report(time_s, state=(0.0,) * 6, *, address=2, centre=(0.0,) * 3, **more):
    north, east, down, *rates = map(float, state)
    position, velocity = (north, east, down), (rates[0], rates[1], rates[2])
    return Report(address, time_s, position, velocity, centre, (0.01, 0.02, 0.03), **more)


def _truth(rng, gaps_s):
    """Return times (n,), states (n, 6) that follow the filter's model, and measurements (n, 6) of them."""
    times_s = np.concatenate([[0.0], np.cumsum(gaps_s)])
    states = [rng.normal(0.0, 1.0, 6)]
    for gap_s in gaps_s:
        noise = rng.multivariate_normal(np.zeros(6), process_noise(gap_s, CONFIG.acceleration_psd))
        states.append(transition_matrix(gap_s) @ states[-1] + noise)
    measured = [rng.multivariate_normal(state, R) for state in states]
    return times_s, np.array(states), np.array(measured)


def _stacked(estimate):
    return np.array((*estimate.position, *estimate.velocity))


@MODERATE
@given(st.floats(1e-3, 20.0), st.floats(1e-4, 1.0))
def test_process_noise_is_van_loans_discretisation(dt_s, psd):
    A = np.zeros((6, 6))
    A[:3, 3:] = np.eye(3)
    spectral = np.zeros((6, 6))
    spectral[3:, 3:] = psd * np.eye(3)
    block = expm(dt_s * np.block([[-A, spectral], [np.zeros((6, 6)), A.T]]))
    F = block[6:, 6:].T
    np.testing.assert_allclose(transition_matrix(dt_s), F, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(process_noise(dt_s, psd), F @ block[:6, 6:], rtol=1e-6, atol=1e-12)


def test_waiting_twice_costs_as_much_as_waiting_once_for_long():
    F, Q = transition_matrix(2.0), process_noise(2.0, 0.1)
    np.testing.assert_allclose(F @ process_noise(3.0, 0.1) @ F.T + Q, process_noise(5.0, 0.1))


@pytest.mark.parametrize("seed", range(3))
def test_on_this_linear_model_it_is_the_kalman_filter(seed):
    rng = np.random.default_rng(seed)
    times_s, _, measured = _truth(rng, rng.uniform(0.2, 8.0, 40))
    table = NeighbourTable(CONFIG)
    kalman = KalmanFilter(dim_x=6, dim_z=6)
    kalman.H, kalman.R = np.eye(6), R
    for index, (time_s, z) in enumerate(zip(times_s, measured, strict=True)):
        table.receive(_report(time_s, z))
        if index == 0:
            kalman.x, kalman.P = z.copy(), R.copy()
        else:
            gap_s = time_s - times_s[index - 1]
            kalman.predict(F=transition_matrix(gap_s), Q=process_noise(gap_s, CONFIG.acceleration_psd))
            kalman.update(z)
        (estimate,) = table.estimates(time_s)
        np.testing.assert_allclose(_stacked(estimate), kalman.x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(estimate.covariance, kalman.P, rtol=1e-9, atol=1e-12)
        (later,) = table.estimates(time_s + 3.0)
        ahead, cost = transition_matrix(3.0), process_noise(3.0, CONFIG.acceleration_psd)
        np.testing.assert_allclose(_stacked(later), ahead @ kalman.x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(later.covariance, ahead @ kalman.P @ ahead.T + cost, rtol=1e-9, atol=1e-12)


def test_covariance_stays_symmetric_and_positive_over_many_updates():
    rng = np.random.default_rng(7)
    times_s, _, measured = _truth(rng, rng.choice([0.1, 1.0, 25.0], 400))
    table = NeighbourTable(CONFIG)
    for time_s, z in zip(times_s, measured, strict=True):
        table.receive(_report(time_s, z))
        (estimate,) = table.estimates(time_s + 0.05)
        P = estimate.covariance
        np.testing.assert_allclose(P, P.T, atol=1e-15)
        assert np.linalg.eigvalsh(P).min() > 0.0


def test_errors_are_as_large_as_the_filter_believes():
    """NEES of 100 runs on truth that follows the model: the mean lies in the chi-square band at all times."""
    runs, packets, wait_s = 100, 25, 1.3
    nees = np.zeros((runs, packets))
    for run in range(runs):
        rng = np.random.default_rng((11, run))
        times_s, states, measured = _truth(rng, np.full(packets, 2.0))
        table = NeighbourTable(CONFIG)
        for index in range(packets):
            table.receive(_report(times_s[index], measured[index]))
            (estimate,) = table.estimates(times_s[index] + wait_s)
            ahead = transition_matrix(wait_s) @ states[index]
            truth = rng.multivariate_normal(ahead, process_noise(wait_s, CONFIG.acceleration_psd))
            error = _stacked(estimate) - truth
            nees[run, index] = error @ np.linalg.solve(estimate.covariance, error)
    low, high = np.array(stats.chi2.interval(1.0 - 1e-4, 6 * runs)) / runs
    assert ((low < nees.mean(axis=0)) & (nees.mean(axis=0) < high)).all()
    assert nees.mean() == pytest.approx(6.0, abs=0.3)


def test_a_late_packet_updates_at_its_own_time():
    """The same packets give the same estimate, whether they come at once or seconds late."""
    rng = np.random.default_rng(3)
    times_s, _, measured = _truth(rng, np.full(10, 1.0))
    prompt, late = NeighbourTable(CONFIG), NeighbourTable(CONFIG)
    for time_s, z in zip(times_s, measured, strict=True):
        prompt.receive(_report(time_s, z))
        prompt.estimates(time_s + 0.9)
    for time_s, z in zip(times_s, measured, strict=True):
        late.receive(_report(time_s, z))
    (a,), (b,) = prompt.estimates(17.0), late.estimates(17.0)
    np.testing.assert_array_equal(_stacked(a), _stacked(b))
    np.testing.assert_array_equal(a.covariance, b.covariance)
    assert a.age_s == b.age_s == 7.0


def test_the_first_packet_is_believed_as_it_is_and_carried_with_its_velocity():
    table = NeighbourTable(CONFIG)
    table.receive(_report(10.0, np.array([1.0, 2.0, 3.0, 0.1, 0.0, -0.2])))
    (estimate,) = table.estimates(15.0)
    assert estimate.position == pytest.approx((1.5, 2.0, 2.0))
    assert estimate.velocity == pytest.approx((0.1, 0.0, -0.2))


def test_what_a_neighbour_says_of_centre_flock_and_heading_stays_as_it_was_said():
    table = NeighbourTable(CONFIG)
    table.receive(
        _report(
            10.0,
            centre=(1.0, 1.0, 1.0),
            flock_stamp_s=7.0,
            flock_turn_rate_radps=0.01,
            heading_rad=2.0,
            is_holding=True,
            heard_code=4,
            heard_mask=0b1001,
        )
    )
    (estimate,) = table.estimates(12.0)
    assert estimate.centre == (1.0, 1.0, 1.0)
    assert (estimate.flock_velocity, estimate.flock_stamp_s) == ((0.01, 0.02, 0.03), 7.0)
    assert (estimate.flock_turn_rate_radps, estimate.heading_rad) == (0.01, 2.0)
    assert (estimate.is_holding, estimate.heard_within_s, estimate.heard_mask) == (True, 4.0, 0b1001)


def test_what_an_older_report_lacks_is_believed_with_caution():
    """No turn, no heading, not holding, no vehicle heard."""
    unknown = dict.fromkeys(("is_bounded", "is_holding", "heard_code", "heard_mask"))
    table = NeighbourTable(CONFIG)
    table.receive(_report(10.0, flock_turn_rate_radps=math.nan, heading_rad=math.nan, **unknown))
    (estimate,) = table.estimates(12.0)
    assert estimate.flock_turn_rate_radps == 0.0
    assert math.isnan(estimate.heading_rad)
    assert (estimate.is_holding, estimate.heard_mask) == (False, 0)


def test_repeated_packets_are_counted_and_change_nothing():
    table = NeighbourTable(CONFIG)
    for time_s in (9.0, 10.0):
        table.receive(_report(time_s, np.ones(6)))
    before = _stacked(table.estimates(11.0)[0])
    for time_s in (9.0, 10.0):
        table.receive(_report(time_s, 5.0 * np.ones(6)))
    assert table.outdated == 2
    np.testing.assert_array_equal(_stacked(table.estimates(11.0)[0]), before)


def test_a_silent_neighbour_no_longer_counts_after_the_time_out_and_comes_back():
    table = NeighbourTable(CONFIG)
    table.receive(_report(0.0))
    assert len(table.estimates(30.0)) == 1
    assert len(table.estimates(30.001)) == 0
    assert table.heard == 1
    table.receive(_report(40.0))
    assert len(table.estimates(40.0)) == 1


def test_neighbours_come_in_the_order_of_addresses_with_a_filter_each():
    table = NeighbourTable(CONFIG)
    for address in (7, 2, 4):
        table.receive(_report(0.0, np.full(6, float(address)), address=address))
    estimates = table.estimates(0.0)
    assert [estimate.address for estimate in estimates] == [2, 4, 7]
    assert [estimate.position[0] for estimate in estimates] == [2.0, 4.0, 7.0]


def test_asking_changes_nothing():
    asked, left = NeighbourTable(CONFIG), NeighbourTable(CONFIG)
    for time_s in (0.0, 1.0, 2.0):
        for table in (asked, left):
            table.receive(_report(time_s, np.full(6, time_s)))
        for ahead_s in (0.1, 5.0, 0.3):
            estimate = asked.estimates(time_s + ahead_s)[0]
            estimate.covariance[:] = 0.0
    np.testing.assert_array_equal(asked.estimates(3.0)[0].covariance, left.estimates(3.0)[0].covariance)
