"""Claims about dead reckoning: its drift, its stated error, and the effect of a fix."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.geometry import heading_from_quaternion, quaternion_from_heading
from auv_core.messages import VehicleState
from auv_core.params import ConfigError, load
from auv_core.state_checks import checked_state
from auv_sim.navigation import dead_reckoning
from auv_sim.navigation._drift import Drift
from auv_sim.navigation.dead_reckoning import Navigation, Params

PERIOD_S = 0.1
SPEED_MPS = 0.5
QUIET: dict[str, Any] = {
    "velocity_bias_mps": 0.0,
    "velocity_sd_mps": 0.0,
    "heading_bias_rad": 0.0,
    "depth_sd_m": 0.0,
}


def straight(tick, period_s=PERIOD_S):
    """Return the truth of a vehicle that goes north-east at 5 m depth."""
    s_m = SPEED_MPS * tick * period_s / math.sqrt(2.0)
    attitude = quaternion_from_heading(0.25 * math.pi)
    return VehicleState(tick, (s_m, s_m, 5.0), attitude, (SPEED_MPS, 0.0, 0.0, 0.0, 0.0, 0.1))


def circling(tick, period_s=PERIOD_S):
    """Return the truth of a vehicle that goes round a circle of 5 m with its bow ahead, in 63 s."""
    turn_rad = 0.1 * tick * period_s
    position = (5.0 * math.sin(turn_rad), 5.0 - 5.0 * math.cos(turn_rad), 5.0)
    attitude = quaternion_from_heading(math.remainder(turn_rad, 2.0 * math.pi))
    return VehicleState(tick, position, attitude, (0.5, 0.0, 0.0, 0.0, 0.0, 0.1))


def flown(params, truth, ticks, *, seed=1, address=1, period_s=PERIOD_S):
    navigation = Navigation(params, seed, address, period_s)
    return [navigation.measured(truth(tick, period_s)) for tick in ticks]


def misses_m(params, truth, ticks, seeds, period_s=PERIOD_S):
    """Return (seeds, ticks, 2) horizontal errors and (seeds, ticks) stated standard deviations (m)."""
    true_m = np.array([truth(tick, period_s).position[:2] for tick in ticks])
    runs = [flown(params, truth, ticks, seed=seed, period_s=period_s) for seed in seeds]
    errors_m = np.array([[state.position[:2] for state in run] for run in runs]) - true_m
    return errors_m, np.array([[state.position_sd_m for state in run] for run in runs])


def test_without_errors_it_is_the_truth():
    for state in flown(Params(**QUIET), circling, range(2000)):
        truth = circling(state.tick)
        np.testing.assert_allclose(state.position, truth.position, atol=1e-9)
        np.testing.assert_allclose(state.attitude, truth.attitude, atol=1e-12)
        assert state.nu == truth.nu
        assert (state.position_sd_m, state.heading_sd_rad) == (0.0, 0.0)


def test_the_log_drifts_by_a_centimetre_a_second_somewhere():
    params = Params(**{**QUIET, "velocity_bias_mps": 0.01})
    errors_m, sd_m = misses_m(params, straight, range(0, 2001, 200), range(40))
    drift_m = np.hypot(errors_m[..., 0], errors_m[..., 1])
    np.testing.assert_allclose(drift_m, np.tile(0.01 * 20.0 * np.arange(11), (40, 1)), atol=1e-9)
    np.testing.assert_allclose(sd_m * math.sqrt(2.0), drift_m, atol=1e-9)
    directions = errors_m[:, -1] / drift_m[:, -1:]
    assert np.abs(directions.mean(axis=0)).max() < 3.0 * math.sqrt(0.5 / 40), "no direction is preferred"


def test_a_compass_off_by_half_a_degree_turns_the_track():
    params = Params(**{**QUIET, "heading_bias_rad": math.radians(0.5)})
    state = flown(params, straight, range(2001))[-1]
    off_rad = heading_from_quaternion(state.attitude) - 0.25 * math.pi
    assert abs(off_rad) == pytest.approx(math.radians(0.5))
    assert math.dist(state.position, straight(2000).position) == pytest.approx(
        100.0 * math.radians(0.5), rel=1e-4
    )
    assert state.position_sd_m * math.sqrt(2.0) == pytest.approx(100.0 * math.radians(0.5), rel=1e-3)
    assert state.heading_sd_rad == pytest.approx(math.radians(0.5))
    signs = {
        heading_from_quaternion(flown(params, straight, [0], seed=s)[0].attitude) > 0.25 * math.pi
        for s in range(8)
    }
    assert signs == {True, False}


def test_a_turning_vehicle_carries_the_logs_error_around_and_says_so():
    params = Params(**{**QUIET, "velocity_bias_mps": 0.01})
    errors_m, sd_m = misses_m(params, circling, [*range(0, 629, 4)], range(4))
    drift_m = np.hypot(errors_m[..., 0], errors_m[..., 1])
    assert drift_m.max() == pytest.approx(2.0 * 0.01 / 0.1, rel=0.01)
    assert drift_m[:, -1].max() < 0.01
    np.testing.assert_allclose(sd_m * math.sqrt(2.0), drift_m, atol=1e-9)


def test_velocity_and_depth_have_the_noise_asked_for_and_depth_does_not_drift():
    params = Params()
    states = flown(params, straight, range(6000))
    off = np.array([state.nu[:3] for state in states]) - (SPEED_MPS, 0.0, 0.0)
    np.testing.assert_allclose(off.std(axis=0), 0.02, rtol=0.05)
    assert math.hypot(*off[:, :2].mean(axis=0)) == pytest.approx(0.01, abs=4.0 * 0.02 / math.sqrt(6000))
    depth_m = np.array([state.position[2] for state in states]) - 5.0
    assert depth_m.std() == pytest.approx(0.01, rel=0.05)
    assert abs(depth_m[-1000:].mean()) < 0.002
    assert all(state.nu[3:] == (0.0, 0.0, 0.1) and checked_state(state)[0] is state for state in states)


@pytest.mark.parametrize("truth", [straight, circling])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"start_sd_m": 0.5, "heading_bias_rad": math.radians(3.0)},
        {"fix": "lbl"},
        {"fix": "lbl", "fix_period_s": 20.0, "learns_biases": True, "heading_bias_rad": math.radians(3.0)},
    ],
    ids=["alone", "uncertain start", "fixes", "many fixes that teach"],
)
def test_the_stated_uncertainty_is_that_of_the_errors(truth, changes):
    """
    Over 200 runs |error|^2 / (2 sd^2) is on average one: its variance is at most one where both components
    are Gaussian, so four deviations of the mean are 0.28; runs of 300 s, looked at every 20 s.
    """
    params, ticks = Params(**changes), range(121)
    errors_m, sd_m = misses_m(params, truth, ticks, range(200), period_s=2.5)
    nees = (errors_m**2).sum(axis=-1)[:, 8::8] / (2.0 * sd_m[:, 8::8] ** 2)
    assert np.abs(nees.mean(axis=0) - 1.0).max() < 0.28
    assert nees.mean() == pytest.approx(1.0, abs=0.12)


def test_the_stated_heading_is_that_of_the_errors():
    params = Params(fix="lbl", fix_period_s=30.0, learns_biases=True, heading_bias_rad=math.radians(3.0))
    ends = [flown(params, straight, range(121), seed=seed, period_s=2.5)[-1] for seed in range(200)]
    errors_rad = np.array([heading_from_quaternion(end.attitude) for end in ends]) - 0.25 * math.pi
    assert ends[0].heading_sd_rad < 0.3 * math.radians(3.0), "what sway cannot explain"
    assert (errors_rad**2).mean() / ends[0].heading_sd_rad ** 2 == pytest.approx(1.0, abs=0.4)


def test_a_fix_stops_the_drift_and_teaching_slows_it():
    ticks = range(261)
    rms = {}
    cases: dict[str, dict[str, Any]] = {
        "none": {},
        "lbl": {"fix": "lbl"},
        "teaching": {"fix": "lbl", "learns_biases": True},
    }
    for name, changes in cases.items():
        errors_m, sd_m = misses_m(Params(**changes), straight, ticks, range(40), period_s=2.5)
        rms[name] = np.sqrt((errors_m[:, 120:] ** 2).sum(axis=-1).mean())
        if changes:
            at_fix = sd_m[:, 24::24]
            assert (at_fix < sd_m[:, 23::24][:, : at_fix.shape[1]]).all()
            assert (at_fix <= 0.3).all()
    assert rms["none"] > 3.0
    assert rms["lbl"] < 1.0
    assert rms["teaching"] < rms["lbl"]


def test_a_good_fix_is_nearly_believed_and_a_bad_one_nearly_not():
    for sd_m, believed in ((0.001, 1.0), (100.0, 0.0)):
        drift = Drift(1.0, 0.0, 0.0, learns=False)
        north, east, *offsets = drift.correct((1.0, -2.0), sd_m)
        assert (north, east) == pytest.approx((believed, -2.0 * believed), abs=1e-3)
        assert offsets == [0.0, 0.0, 0.0]
        assert math.sqrt(drift.position_variance_m2) == pytest.approx(min(sd_m, 1.0), rel=1e-3)


def test_a_fix_without_error_on_a_start_without_error_is_no_trouble():
    drift = Drift(0.0, 0.0, 0.0, learns=True)
    assert drift.correct((0.0, 0.0), 0.0) == (0.0,) * 5
    assert drift.position_variance_m2 == 0.0


moves = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-math.pi, math.pi), st.booleans())


@settings(max_examples=60, deadline=None)
@given(st.lists(moves, min_size=1, max_size=12), st.booleans())
def test_the_variance_in_plain_numbers_is_that_of_the_matrix(sequence, learns):
    drift = Drift(0.1, 0.02, 0.01, learns=learns)
    for north, east, heading_rad, is_fixed in sequence:
        c, s = math.cos(heading_rad), math.sin(heading_rad)
        drift.advance((north, east), (c, s, -s, c), 7.0, 0.03)
        if is_fixed:
            drift.correct((north, east), 0.2)
        P = drift.covariance()
        assert drift.position_variance_m2 == pytest.approx(0.5 * (P[0, 0] + P[1, 1]), rel=1e-9)
        assert drift.heading_variance_rad2 == P[2, 2]
        np.testing.assert_array_equal(P, P.T) if is_fixed else np.testing.assert_allclose(P, P.T, atol=1e-15)
        assert np.linalg.eigvalsh(P).min() > -1e-12


def fix_ticks(params, depth_m, ticks):
    def truth(tick, period_s):
        return VehicleState(tick, (0.0, 0.0, depth_m(tick * period_s)), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)

    sd_m = [state.position_sd_m for state in flown(params, truth, ticks)]
    return [tick for tick, drop in zip(ticks[1:], np.diff(sd_m), strict=True) if drop < 0.0]


def test_fixes_come_at_their_period_and_not_at_the_start():
    params = Params(fix="lbl", fix_period_s=20.0, fix_sd_m=0.05)
    assert fix_ticks(params, lambda t_s: 5.0, range(1000)) == [200, 400, 600, 800]


def test_a_surface_fix_waits_until_the_vehicle_is_shallow():
    params = Params(fix="surface", fix_period_s=20.0, fix_sd_m=0.05)
    assert fix_ticks(params, lambda t_s: 5.0, range(1000)) == []
    assert fix_ticks(params, lambda t_s: 0.2 if 50.0 <= t_s < 75.0 else 5.0, range(1000)) == [500, 600]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31 - 1), st.integers(1, 254))
def test_errors_belong_to_seed_vehicle_and_tick(seed, address):
    params = Params(fix="lbl", fix_period_s=3.0)
    first = flown(params, circling, range(150), seed=seed, address=address)
    assert flown(params, circling, range(150), seed=seed, address=address) == first
    other = flown(params, circling, range(150), seed=seed, address=address % 254 + 1)
    assert other[40].nu != first[40].nu
    assert all(math.isfinite(state.position_sd_m) and state.position_sd_m >= 0.0 for state in first)


def test_noise_of_a_tick_does_not_depend_on_the_ticks_asked_before():
    every, some = (
        {s.tick: s.nu for s in flown(Params(), straight, ticks)} for ticks in (range(300), range(0, 300, 7))
    )
    assert all(every[tick] == nu for tick, nu in some.items())


def test_what_is_refused():
    with pytest.raises(ConfigError, match=r"^x\.fix: 'gps' is not allowed; allowed: none, surface, lbl"):
        load(dead_reckoning.Params, {"fix": "gps"}, "x")
    with pytest.raises(ConfigError, match=r"^x\.fix_period_s: 0\.0 is not allowed"):
        load(dead_reckoning.Params, {"fix_period_s": 0.0}, "x")


@pytest.mark.parametrize("learns", [False, True])
def test_a_fix_moves_the_frame_of_odometry_and_not_the_pose_in_it(learns):
    params = Params(fix="lbl", fix_period_s=10.0, velocity_bias_mps=0.2, learns_biases=learns)
    navigation = Navigation(params, 1, 1, PERIOD_S)
    frames, jumps_m, leaps_m = [], [], []
    before = None
    for tick in range(600):
        nav = navigation.measured(straight(tick))
        seen = navigation.odom_frame.pose(nav.position, nav.attitude)[0]
        if before is not None:
            jumps_m.append(math.dist(seen[:2], before[0][:2]))
            leaps_m.append(math.dist(nav.position[:2], before[1][:2]))
        before = seen, nav.position
        frames.append(navigation.odom_frame)
    assert len(set(frames)) >= 6
    assert max(leaps_m) > 0.5  # the estimate does jump
    assert max(jumps_m) < 0.1


def test_without_fixes_the_frame_of_odometry_is_the_world():
    navigation = Navigation(Params(), 1, 1, PERIOD_S)
    for tick in range(100):
        navigation.measured(straight(tick))
    assert navigation.odom_frame == (0.0, 0.0, 0.0)
