"""Claims about runs in one process: determinism, order, the numbers of ch. 5, the bars of the main job."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from auv_core.geometry import body_to_ned
from auv_core.messages import VehicleState, Wrench
from auv_experiment.compose import vehicle_configs
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario
from auv_sim.vehicle import Vehicle


def _run(name, *overrides, seed=None, duration_s=None):
    scenario = load_scenario(name, overrides=overrides, seed=seed, duration_s=duration_s)
    return scenario, run_in_process(scenario)


def _metrics(name, *overrides, seed=None, duration_s=None):
    scenario, recording = _run(name, *overrides, seed=seed, duration_s=duration_s)
    return compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)


def _differing(a: Recording, b: Recording):
    """Return the names of the fields that are not equal to the last bit."""
    return [
        field.name
        for field in dataclasses.fields(Recording)
        if field.name != "vehicle_ids"
        and not np.array_equal(getattr(a, field.name), getattr(b, field.name), equal_nan=True)
    ]


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("flock_acoustic", ()),
        ("ch5_one_leader_blind", ("sampling=sampled",)),
        ("ch5_obstacles", ()),
    ],
)
def test_two_runs_with_one_seed_are_equal_to_the_last_bit(name, overrides):
    first, second = (_run(name, *overrides, duration_s=8.0)[1] for _ in range(2))
    assert _differing(first, second) == []


def test_another_seed_gives_other_starts_and_other_losses():
    (_, first), (_, second) = (_run("flock_acoustic", seed=seed, duration_s=8.0) for seed in (1, 2))
    assert {"position_ned_m", "received"} <= set(_differing(first, second))


def test_with_the_same_starts_another_seed_loses_other_packets():
    starts = [f"vehicles.{i}.position_ned_m=[{4 * i}, 9, 8]" for i in range(4)]
    (_, first), (_, second) = (_run("flock_acoustic", *starts, seed=seed, duration_s=8.0) for seed in (1, 2))
    np.testing.assert_array_equal(first.position_ned_m[0], second.position_ned_m[0])
    assert "received" in _differing(first, second)


def test_command_k_acts_from_tick_k_to_the_next():
    scenario, recording = _run("flock_acoustic", duration_s=4.0)
    for index, config in enumerate(vehicle_configs(scenario)):
        vehicle = Vehicle(config)
        for tick in (0, 7, 39):
            rows = (recording.position_ned_m, recording.attitude_quat_wxyz, recording.velocity_body)
            position, attitude, nu = (tuple(row[tick, index].tolist()) for row in rows)
            vehicle.restore(VehicleState(tick, position, attitude, nu))
            after = vehicle.step(Wrench(tuple(recording.command[tick, index].tolist())))
            np.testing.assert_array_equal(after.position, recording.position_ned_m[tick + 1, index])
            np.testing.assert_array_equal(after.nu, recording.velocity_body[tick + 1, index])


def test_packets_follow_the_slots_and_arrive_in_a_later_tick():
    _, recording = _run("flock_acoustic", duration_s=20.0)
    slots = recording.sent[:, 0] * 0.1 / 0.25
    assert (np.round(np.ceil(slots - 1e-9)) % 4 + 1 == recording.sent[:, 1]).all()
    sent_in = {(source, sequence): tick for tick, source, sequence in recording.sent.tolist()}
    for tick, source, destination, sequence in recording.received.tolist():
        assert source != destination
        assert tick > sent_in[source, sequence]
    airtime_s = 8.0 * 32 / 5000.0
    assert (recording.delay_s > airtime_s).all()
    assert (recording.delay_s < airtime_s + 40.0 / 1500.0).all()


def test_a_sampled_run_tends_to_the_continuous_one_as_its_period_shrinks():
    _, continuous = _run("ch5_one_leader_blind", duration_s=6.0)
    errors = []
    for period_s in (0.1, 0.05):
        overrides = ("sampling=sampled", f"period_s={period_s}", "dt_s=0.01")
        _, sampled = _run("ch5_one_leader_blind", *overrides, duration_s=6.0)
        stride = round(0.1 / period_s)
        errors.append(np.abs(sampled.position_ned_m[::stride] - continuous.position_ned_m).max())
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.15)


def test_blind_followers_learn_of_the_path_by_packets_only():
    """With every packet lost, another path changes what the leader does and nothing that a follower does."""
    deaf = ("acoustics.outage.params.loss_prob=1.0", "agent.hold_s=0")
    _, circle = _run("flock_acoustic", *deaf, duration_s=8.0)
    _, other = _run("flock_acoustic", *deaf, "reference.params.depth_m=20", duration_s=8.0)
    np.testing.assert_array_equal(circle.position_ned_m[:, 1:], other.position_ned_m[:, 1:])
    assert np.abs(circle.position_ned_m[-1, 0] - other.position_ned_m[-1, 0]).max() > 0.1


def test_progress_is_told_and_ends_with_the_run():
    told: list[Any] = []
    run_in_process(load_scenario("flock_acoustic", duration_s=30.0), on_progress=told.append)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(30.0)


@pytest.fixture(scope="module")
def main_job():
    return _run("flock_acoustic", duration_s=60.0)


def test_the_main_job_holds_its_bars_over_its_first_minute(main_job):
    scenario, recording = main_job
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    assert metrics["pair_distance_min_m"] >= 0.8
    assert not metrics["collision"]
    assert metrics["formed_at_s"] <= 60.0
    assert metrics["pair_distance_formed_min_m"] >= 1.0
    assert metrics["pair_distance_formed_max_m"] <= 4.0
    assert metrics["obstacle_clearance_min_m"] >= 0.5
    sent = metrics["packets_sent"] * 3
    assert metrics["packet_delivery_ratio"] == pytest.approx(0.8, abs=4.0 * math.sqrt(0.16 / sent))


def test_the_main_job_stays_below_the_surface_and_within_its_actuators(main_job):
    scenario, recording = main_job
    assert (recording.position_ned_m[..., 2] > scenario.hull_radius_m).all()
    limits = np.array([vehicle.model.params.max_wrench for vehicle in scenario.vehicles])
    assert (np.abs(recording.command) <= limits).all()
    np.testing.assert_allclose(np.linalg.norm(recording.attitude_quat_wxyz, axis=-1), 1.0, atol=1e-12)


def test_the_main_job_tracks_its_velocity_reference_over_ground(main_job):
    """
    The inner loop is faster than the flock: the rms error is a few cm/s in spite of the current, and of
    packets, each of which changes what is asked.
    """
    _, recording = main_job
    errors = [
        np.subtract(
            body_to_ned(tuple(recording.attitude_quat_wxyz[k, i]), tuple(recording.velocity_body[k, i, :3])),
            recording.reference_velocity_ned_mps[k, i],
        )
        for k in range(300, recording.n_ticks, 5)
        for i in range(recording.n_vehicles)
    ]
    assert np.sqrt(np.mean(np.sum(np.square(errors), axis=1))) < 0.08


def test_the_main_jobs_neighbour_errors_are_no_larger_than_the_filters_believe(main_job):
    """At least 95 % of them lie within two sigmas (all of them do: own navigation is exact here)."""
    _, recording = main_job
    late = slice(300, None)
    error = recording.neighbour_position_ned_m[late] - recording.position_ned_m[late][:-1, np.newaxis]
    sigma = np.sqrt(np.diagonal(recording.neighbour_covariance[late], axis1=-2, axis2=-1)[..., :3])
    known = np.isfinite(error) & np.isfinite(sigma)
    assert known.any()
    assert (np.abs(error[known]) <= 2.0 * sigma[known]).mean() >= 0.95


# Spec of ch. 5, section 3, over a short horizon: smallest distance ever (m), time of the 2 % approach (s).
APPROACH = {"ch5_four_leaders": (1.451, 3.90), "ch5_one_leader": (1.449, 4.00)}


@pytest.mark.parametrize("name", APPROACH)
def test_the_thesis_flock_approaches_as_the_spec_says(name):
    smallest_m, approach_s = APPROACH[name]
    metrics = _metrics(name, duration_s=40.0)
    assert metrics["pair_distance_min_m"] == pytest.approx(smallest_m, abs=0.003)
    assert metrics["approach_time_2pct_s"] == pytest.approx(approach_s, abs=0.1)


def test_four_leaders_settle_in_the_tetrahedron_of_the_spec():
    """All six distances are the root of K = 2 n (d^2 - r^2) / r^4: 1.5950 m."""
    _, recording = _run("ch5_four_leaders", duration_s=20.0)
    np.testing.assert_allclose(pair_distances_m(recording)[-50:], 1.5950, atol=1e-3)


def test_the_blind_flock_never_comes_nearer_than_the_spec_says():
    metrics = _metrics("ch5_one_leader_blind", duration_s=60.0)
    assert metrics["pair_distance_min_m"] == pytest.approx(1.605, abs=0.003)


@pytest.mark.parametrize("dt_s", [0.02, 0.005])
def test_the_step_of_continuous_time_is_fine_enough(dt_s):
    (_, usual), (_, other) = (
        _run("ch5_obstacles", f"dt_s={step}", duration_s=6.0) for step in (0.01, dt_s)
    )  # fmt: skip
    np.testing.assert_allclose(other.position_ned_m, usual.position_ned_m, atol=1e-4)
