"""Claims about one neighbour's filter through time: order, history, offsets and fixes."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from auv_core.messages import VehicleState
from auv_flocking.neighbours import navigation_offset as offset
from auv_flocking.neighbours.filter import NeighbourConfig, NeighbourFilter
from auv_flocking.neighbours.motion import carried, flock_motion, grown, process_noise, transition_matrix
from auv_flocking.neighbours.navigation_offset import OwnFix, Stated
from auv_flocking.neighbours.sonar_contact import contact_of, sighting
from auv_flocking.neighbours.synthetic_neighbour import Setting, fly
from auv_flocking.neighbours.table import NeighbourTable
from auv_flocking.neighbours.track import HISTORY_S, HeardReport, Track
from auv_flocking.report import Report

CONFIG = NeighbourConfig()
RATE = CONFIG.drift_rate_mps
MODERATE = settings(max_examples=25, deadline=None)
ZERO = (0.0, 0.0, 0.0)


def _report(time_s, position=ZERO, velocity=ZERO, sd_m=0.0, centre=ZERO):
    return Report(2, time_s, position, velocity, centre, ZERO, position_sd_m=sd_m)


def _heard(time_s, position=ZERO, velocity=ZERO, sd_m=0.0, own_sd_m=0.0):
    return HeardReport(_report(time_s, position, velocity, sd_m), Stated(own_sd_m**2, sd_m**2))


def _nav(t_s, position=ZERO, velocity=ZERO, sd_m=0.0):
    return VehicleState(
        round(10 * t_s), position, (1.0, 0.0, 0.0, 0.0), (*velocity, 0.0, 0.0, 0.0), True, sd_m
    )


def _sighting(t_s, position):
    return sighting(t_s, _nav(t_s), contact_of(position), 0.1, 0.0175)


def _track(first, config=CONFIG):
    return Track(first, NeighbourFilter(config), config.velocity_memory_s)


def _measurements(rng, sd_m):
    """Return packets, contacts and fixes of one neighbour, in the order in which they happened."""
    all_of_them: list[Any] = []
    for time_s in np.sort(rng.uniform(0.0, 0.9 * HISTORY_S, 14)).tolist():
        position = tuple((rng.standard_normal(3) * 0.1 + (3.0, 2.0, 1.0)).tolist())
        kind = rng.integers(0, 5) if all_of_them else 0
        if kind < 2:
            velocity = tuple((0.02 * rng.standard_normal(3)).tolist())
            stated_m = sd_m * (1.0 + 0.1 * time_s) if rng.random() < 0.8 else 0.4 * sd_m
            all_of_them.append(_heard(time_s, position, velocity, stated_m, sd_m))
        elif kind < 4 or sd_m == 0.0:
            all_of_them.append(_sighting(time_s, position))
        else:
            all_of_them.append(OwnFix(time_s, (0.3, -0.2), (2.0 * sd_m) ** 2, sd_m**2))
    return all_of_them


def _use(track, measurement):
    if isinstance(measurement, HeardReport):
        assert track.hear(measurement)
    elif isinstance(measurement, OwnFix):
        track.move_frame(measurement)
    else:
        track.see(measurement)


@MODERATE
@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.5]), st.floats(0.0, 15.0))
def test_whatever_the_order_of_arrival_the_estimate_is_that_of_the_right_order(seed, sd_m, lateness_s):
    rng = np.random.default_rng(seed)
    measurements = _measurements(rng, sd_m)
    ordered, disordered = _track(measurements[0]), _track(measurements[0])
    for measurement in measurements[1:]:
        _use(ordered, measurement)
    # Packets arrive late, everything else at once.
    arrivals = [
        m.time_s + (rng.uniform(0.0, lateness_s) if isinstance(m, HeardReport) else 0.0)
        for m in measurements[1:]
    ]
    for index in np.argsort(arrivals, kind="stable"):
        _use(disordered, measurements[1 + index])
    a, b = ordered.estimate(25.0), disordered.estimate(25.0)
    assert a.position == b.position
    assert a.velocity == b.velocity
    assert (a.time_s, a.age_s, a.sonar_age_s, a.centre) == (b.time_s, b.age_s, b.sonar_age_s, b.centre)
    np.testing.assert_array_equal(a.covariance, b.covariance)


def test_a_packet_from_before_the_first_one_begins_the_track_anew():
    early, late = _heard(1.0, (1.0, 0.0, 0.0)), _heard(3.0, (1.2, 0.0, 0.0))
    ordered, disordered = _track(early), _track(late)
    assert ordered.hear(late)
    assert disordered.hear(early)
    assert ordered.estimate(4.0).position == disordered.estimate(4.0).position
    assert disordered.report.time_s == 3.0


def test_what_is_older_than_the_history_is_refused_and_counted():
    table = NeighbourTable(CONFIG)
    for time_s in np.arange(0.0, 2.0 * HISTORY_S, 1.0).tolist():
        table.receive(_report(time_s))
    before = table.estimates(2.0 * HISTORY_S)[0]
    table.receive(_report(HISTORY_S - 2.5, (9.0, 9.0, 9.0)))
    assert table.outdated == 1
    assert table.estimates(2.0 * HISTORY_S)[0].position == before.position
    table.receive(_report(HISTORY_S + 2.5))
    assert table.outdated == 1


def test_the_density_follows_how_much_a_neighbour_changes_its_velocity():
    rng = np.random.default_rng(2)
    config = NeighbourConfig(acceleration_memory_s=60.0)
    for psd, expected in ((3e-3, 4.5e-3), (2e-4, 3e-4), (0.0, 1e-5), (1.0, 1e-2)):
        velocity, track = np.zeros(3), _track(_heard(0.0), config)
        for time_s in range(2, 600, 2):
            velocity = velocity + math.sqrt(2.0 * psd) * rng.standard_normal(3)
            assert track.hear(_heard(float(time_s), velocity=tuple(velocity.tolist())))
        assert expected / 2.0 < track.belief.psd < expected * 2.0
    assert _track(_heard(0.0), config).belief.psd == pytest.approx(1e-2), "it may be about to set off"
    fixed = _track(_heard(0.0))
    assert fixed.hear(_heard(2.0, velocity=(1.0, 0.0, 0.0)))
    assert fixed.belief.psd == CONFIG.acceleration_psd


@pytest.mark.parametrize("gap_s", [2.0, 8.0])
def test_a_jitter_of_the_velocity_is_as_uncertain_after_a_gap_as_it_makes_the_position_wrong(gap_s):
    """A velocity that jitters by s misplaces a neighbour by s times the gap: NEES 3 just before a packet."""
    rng, jitter_mps, squares = np.random.default_rng(4), 0.05, []
    track = _track(_heard(0.0), NeighbourConfig(acceleration_memory_s=300.0, velocity_std_mps=1e-3))
    for count in range(1, 600):
        time_s = gap_s * count
        if count > 100:
            estimate = track.estimate(time_s)
            error = np.array(estimate.position)
            squares.append(error @ np.linalg.solve(estimate.covariance[:3, :3], error))
        assert track.hear(_heard(time_s, velocity=tuple((jitter_mps * rng.standard_normal(3)).tolist())))
    assert np.mean(squares) == pytest.approx(3.0, rel=0.2)


def test_memory_is_bounded():
    track = _track(_heard(0.0))
    for tick in range(1, 3000):
        track.see(_sighting(0.01 * tick, (1.0, 1.0, 1.0)))
    assert len(track._measurements) == len(track._beliefs) <= 128


@MODERATE
@given(st.floats(0.01, 20.0), st.floats(1e-5, 1e-1), st.floats(1e-9, 1e-5), st.sampled_from([0.0, 3.0, 30.0]))
def test_discretisation_with_an_offset_is_van_loans(dt_s, psd, rate_psd, memory_s):
    A = np.zeros((10, 10))
    A[:3, 3:6], A[6:8, 8:] = np.eye(3), np.eye(2)
    if memory_s:
        A[3:6, 3:6] = -np.eye(3) / memory_s
    spectral = np.diag([0.0] * 3 + [psd] * 3 + [0.0] * 2 + [rate_psd] * 2)
    block = expm(dt_s * np.block([[-A, spectral], [np.zeros((10, 10)), A.T]]))
    F = block[10:, 10:].T
    np.testing.assert_allclose(offset.offset_transition(dt_s, memory_s), F, rtol=1e-9, atol=1e-12)
    Q = offset.offset_noise(dt_s, psd, rate_psd, memory_s)
    np.testing.assert_allclose(Q, F @ block[:10, 10:], rtol=1e-6, atol=1e-11)


@MODERATE
@given(st.integers(0, 10**6), st.floats(0.0, 30.0), st.sampled_from([0.0, 3.0, 30.0]))
def test_the_sum_of_parts_is_the_product(seed, dt_s, memory_s):
    root = np.random.default_rng(seed).standard_normal((6, 6))
    P, F = root @ root.T, transition_matrix(dt_s, memory_s)
    expected = F @ P @ F.T + process_noise(dt_s, 2e-3, memory_s)
    after = np.empty(36)
    grown(P.ravel(), dt_s, 2e-3, memory_s, after)
    np.testing.assert_allclose(after.reshape(6, 6), expected, rtol=1e-9, atol=1e-9)


def test_a_velocity_comes_back_to_the_flocks():
    """By e after one memory; and carried at once or by a contact in between, it is the same way."""
    config = NeighbourConfig(velocity_memory_s=10.0)
    report = Report(2, 0.0, ZERO, (0.5, 0.0, 0.0), ZERO, (0.1, 0.0, 0.0))
    track = _track(HeardReport(report, Stated(0.0, 0.0)), config)
    estimate = track.estimate(10.0)
    assert estimate.velocity[0] == pytest.approx(0.1 + 0.4 * math.exp(-1.0))
    assert estimate.position[0] == pytest.approx(0.1 * 10.0 + 0.4 * 10.0 * (1.0 - math.exp(-1.0)))
    half_way = track.estimate(5.0).position
    track.see(sighting(5.0, _nav(5.0), contact_of(half_way), 1.0, 1.0))
    assert track.estimate(10.0).position == pytest.approx(estimate.position, abs=1e-9)
    assert track.estimate(300.0).covariance[3, 3] == pytest.approx(0.5 * 1e-3 * 10.0, rel=0.01)


def test_with_an_offset_and_no_sonar_it_is_the_kalman_filter_on_ten_states():
    rng = np.random.default_rng(4)
    track, kalman = _track(_heard(0.0, (1.0, 2.0, 3.0), (0.1, 0.0, 0.0), 0.1, 0.2)), KalmanFilter(10, 6)
    R = np.diag([CONFIG.position_std_m**2] * 3 + [CONFIG.velocity_std_mps**2] * 3)
    kalman.H, kalman.R = offset.PACKET, R
    # By Bayes from nothing: position and velocity unknown, the offset as stated, then the first packet.
    kalman.P = np.diag([1e6] * 6 + [0.05] * 2 + [2.0 * RATE**2] * 2)
    kalman.x = np.zeros(10)
    kalman.update(np.array((1.0, 2.0, 3.0, 0.1, 0.0, 0.0)))
    for time_s in (2.0, 3.0, 7.0):
        z = np.array((1.0 + 0.1 * time_s, 2.0, 3.0, 0.1, 0.0, 0.0)) + 0.01 * rng.standard_normal(6)
        assert track.hear(_heard(time_s, tuple(z[:3].tolist()), tuple(z[3:].tolist()), 0.1, 0.2))
        dt_s = time_s - (0.0 if time_s == 2.0 else 2.0 if time_s == 3.0 else 3.0)
        rate_psd = offset.rate_psd(RATE)
        kalman.predict(
            F=offset.offset_transition(dt_s), Q=offset.offset_noise(dt_s, CONFIG.acceleration_psd, rate_psd)
        )
        kalman.update(z)
    np.testing.assert_allclose(track.belief.x, kalman.x, atol=1e-5)
    np.testing.assert_allclose(track.belief.P, kalman.P, atol=1e-5)


def test_without_sonar_the_position_is_as_uncertain_as_both_navigations_state():
    track = _track(_heard(0.0, sd_m=0.3, own_sd_m=0.4))
    for time_s in range(1, 12):
        # They state far more than their rates account for: what is stated is a floor.
        assert track.hear(_heard(float(time_s), sd_m=0.3 + 0.05 * time_s, own_sd_m=0.4 + 0.05 * time_s))
        stated_m2 = (0.3 + 0.05 * time_s) ** 2 + (0.4 + 0.05 * time_s) ** 2
        assert track.belief.P[0, 0] > 0.75 * stated_m2
        assert track.belief.P[0, 0] < 1.1 * stated_m2
        assert track.belief.P[2, 2] < 0.03**2


def test_a_hundred_packets_do_not_average_an_offset_away():
    track = _track(_heard(0.0, sd_m=1.0, own_sd_m=1.0))
    for k in range(1, 101):
        assert track.hear(_heard(0.1 * k, sd_m=1.0, own_sd_m=1.0))
    assert math.sqrt(track.estimate(10.0).covariance[0, 0]) > 1.4


def test_the_sonar_bounds_the_position_and_tells_the_offset():
    track = _track(_heard(0.0, (4.0, 3.0, 1.0), sd_m=1.0, own_sd_m=1.0))
    for k in range(1, 41):
        track.see(_sighting(0.5 * k, (3.0, 3.5, 1.0)))
        if k % 4 == 0:
            assert track.hear(_heard(0.5 * k + 0.01, (4.0, 3.0, 1.0), sd_m=1.0, own_sd_m=1.0))
    estimate = track.estimate(20.0)
    assert estimate.position == pytest.approx((3.0, 3.5, 1.0), abs=0.02)
    assert math.sqrt(estimate.covariance[0, 0]) < 0.1
    np.testing.assert_allclose(track.belief.x[6:8], (1.0, -0.5), atol=0.1)
    # Out of the sonar's reach, packets carry what it has told.
    for time_s in (22.0, 25.0, 28.0):
        assert track.hear(_heard(time_s, (4.0, 3.0, 1.0), sd_m=1.0, own_sd_m=1.0))
    later = track.estimate(28.0)
    assert later.position == pytest.approx((3.0, 3.5, 1.0), abs=0.1)
    assert math.sqrt(later.covariance[0, 0]) < 0.25


def test_a_neighbours_centre_comes_in_the_own_frame():
    first = HeardReport(_report(0.0, (4.0, 3.0, 1.0), sd_m=1.0, centre=(5.0, 5.0, 5.0)), Stated(0.0, 1.0))
    track = _track(first)
    assert track.estimate(0.0).centre == (5.0, 5.0, 5.0)
    for k in range(1, 21):
        track.see(_sighting(0.5 * k, (3.0, 3.5, 1.0)))
    assert track.estimate(10.0).centre == pytest.approx((4.0, 5.5, 5.0), abs=0.15)


@pytest.mark.parametrize("sender_sd_m", [0.5, 2.0])
def test_after_a_fix_of_the_sender_it_is_as_uncertain_as_the_own_navigation_and_the_fix(sender_sd_m):
    track = _track(_heard(0.0, sd_m=sender_sd_m, own_sd_m=0.7))
    assert track.hear(_heard(1e-6, sd_m=0.2, own_sd_m=0.7))
    assert track.belief.P[0, 0] == pytest.approx(0.7**2 + 0.2**2, rel=0.01)


def test_after_an_own_fix_the_neighbour_is_where_it_was_seen_from_here():
    """And the offset is as uncertain as is then stated."""
    table = NeighbourTable(CONFIG)
    table.estimates(0.0, _nav(0.0, sd_m=1.0))
    table.receive(_report(0.0, (5.0, 0.0, 0.0), sd_m=0.5))
    before = table.estimates(0.1, _nav(0.1, sd_m=1.0))[0]
    assert before.covariance[0, 0] == pytest.approx(1.25, rel=0.01)
    after = table.estimates(0.2, _nav(0.2, (0.8, -0.4, 0.0), sd_m=0.3))[0]
    np.testing.assert_allclose(after.covariance[0, 0], 0.5**2 + 0.3**2, rtol=0.01)
    # The jump says that the own position was off by about as much: so the neighbour is farther off.
    assert after.position[0] == pytest.approx(5.0, abs=0.02)
    assert after.position[1] == pytest.approx(0.0, abs=0.02)


def test_an_own_fix_does_not_move_what_the_sonar_sees():
    table = NeighbourTable(CONFIG)
    table.estimates(0.0, _nav(0.0, sd_m=1.0))
    table.receive(_report(0.0, (5.0, 0.0, 0.0), sd_m=0.5))
    for k in range(1, 21):
        table.observe(0.5 * k, _nav(0.5 * k, sd_m=1.0), [contact_of((5.0, 0.0, 0.0))])
    before = table.estimates(10.0, _nav(10.0, sd_m=1.0))[0]
    after = table.estimates(10.1, _nav(10.1, (0.8, -0.4, 0.0), sd_m=0.3))[0]
    relative = np.array(after.position) - (0.8, -0.4, 0.0)
    np.testing.assert_allclose(relative, before.position, atol=0.02)
    assert after.covariance[0, 0] < 1.1 * before.covariance[0, 0]


def test_a_track_that_cannot_be_true_is_begun_anew():
    """
    Contacts of another vehicle were associated with this neighbour for a while; its packets contradict them.
    """
    track = _track(_heard(0.0, (4.0, 3.0, 1.0), sd_m=0.05, own_sd_m=0.05))
    for k in range(1, 21):
        track.see(_sighting(0.5 * k, (9.0, 3.0, 1.0)))
    for time_s in (10.5, 12.5, 14.5, 16.5):
        assert track.hear(_heard(time_s, (4.0, 3.0, 1.0), sd_m=0.05, own_sd_m=0.05))
    estimate = track.estimate(16.5)
    error_m = math.dist(estimate.position, (4.0, 3.0, 1.0))
    assert error_m < 3.0 * math.sqrt(np.trace(estimate.covariance[:3, :3]))


@pytest.mark.parametrize("drifts", [False, True])
def test_covariance_stays_symmetric_and_positive(drifts):
    _check_covariance(drifts, 600)


@pytest.mark.slow
@pytest.mark.parametrize("drifts", [False, True])
def test_covariance_stays_symmetric_and_positive_over_1e5_steps(drifts):
    _check_covariance(drifts, 100_000)


def _check_covariance(drifts, updates):
    """Packets and contacts at irregular times, with fixes of both navigations; Joseph's form must hold."""
    rng = np.random.default_rng(9)
    gaps_s, chance = rng.choice([0.01, 0.5, 2.0, 25.0], updates), rng.random(updates)
    beliefs = NeighbourFilter(CONFIG)
    belief, seen = (
        beliefs.first(_report(0.0, (3.0, 2.0, 1.0)), Stated(0.0, 0.0)),
        _sighting(0.0, (3.0, 2.0, 1.0)),
    )
    for k, (gap_s, luck) in enumerate(zip(gaps_s.tolist(), chance.tolist(), strict=True)):
        time_s = belief.time_s + gap_s
        sd_m = 0.0 if not drifts else 0.1 + 0.01 * (k % 100)
        if luck < 0.5:
            stated = Stated((0.5 * sd_m) ** 2, sd_m**2)
            belief = beliefs.after_packet(belief, _report(time_s, (3.0, 2.0, 1.0), sd_m=sd_m), stated)
        elif luck < 0.95 or not drifts:
            belief = beliefs.after_sighting(belief, replace(seen, time_s=time_s))
        else:
            belief = beliefs.after_own_fix(belief, OwnFix(time_s, (0.1, -0.1), 0.5, 0.1))
        P = belief.P
        scale = np.sqrt(np.diag(P))
        np.testing.assert_allclose(P / np.outer(scale, scale), P.T / np.outer(scale, scale), atol=1e-9)
        assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > 0.0


def test_exact_navigations_need_no_offset_and_stated_errors_switch_to_it():
    """With nothing stated it is the filter of six states; a stated error adds four, once."""
    for setting, states in (
        (Setting(), 6),
        (Setting(own_rate_mps=RATE), 10),
        (Setting(sender_rate_mps=RATE), 10),
    ):
        table = NeighbourTable(CONFIG)
        for now in fly(setting, CONFIG, np.random.default_rng(1), 10.0):
            for report in now.reports:
                table.receive(report)
            table.estimates(now.t_s, now.nav)
        assert len(table.tracks[0].belief.x) == states


@MODERATE
@given(rate_radps=st.floats(-0.1, 0.1), dt_s=st.floats(0.0, 90.0), memory_s=st.floats(2.0, 60.0))
def test_a_neighbour_is_carried_along_the_circle_of_its_flock(rate_radps, dt_s, memory_s):
    """The way is compared with a sum over short steps; the filter's own prediction is the same."""
    flock, state = (0.2, -0.1, 0.05), np.array([1.0, 2.0, 3.0, 0.3, 0.1, 0.0])
    position, velocity = carried(state, dt_s, memory_s, (*flock, rate_radps))
    steps = 4000
    middle_s = (np.arange(steps) + 0.5) * dt_s / steps
    turn = rate_radps * middle_s
    of_flock = np.array(
        [
            np.cos(turn) * flock[0] - np.sin(turn) * flock[1],
            np.sin(turn) * flock[0] + np.cos(turn) * flock[1],
            np.full(steps, flock[2]),
        ]
    )
    own = np.exp(-middle_s / memory_s) * (state[3:] - flock)[:, None]
    np.testing.assert_allclose(position, state[:3] + (of_flock + own).mean(axis=1) * dt_s, atol=1e-4)
    ahead = transition_matrix(dt_s, memory_s) @ state + flock_motion(dt_s, memory_s, (*flock, rate_radps))
    np.testing.assert_allclose(ahead, (*position, *velocity), atol=1e-12)


def test_a_neighbour_that_holds_station_is_not_carried_with_the_flock():
    config = replace(CONFIG, velocity_memory_s=15.0)
    report = _report(0.0)._replace(flock_velocity=(0.3, 0.0, 0.0), flock_stamp_s=-5.0)
    holding = _track(HeardReport(report._replace(is_holding=True), Stated(0.0, 0.0)), config)
    flying = _track(HeardReport(report, Stated(0.0, 0.0)), config)
    assert holding.estimate(60.0).position == ZERO
    assert flying.estimate(60.0).position[0] > 10.0
