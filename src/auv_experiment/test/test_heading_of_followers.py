"""A run shows it: a flock turns to its leader's heading, and only packets say what that is."""

import numpy as np
import pytest

from auv_core.geometry import heading_from_quaternion
from auv_experiment.inprocess.continuous import run_continuous
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario

DEAF = "acoustics.outage={kind: bernoulli, params: {loss_prob: 1.0}}"
ARRAYS = ("position_ned_m", "attitude_quat_wxyz", "velocity_body", "command")


def flight_of(heading_rad, *overrides):
    overrides = (
        f"reference.params.heading_rad={heading_rad}",
        "dt_s=0.1",
        "agent.hold_s=0.0",
        *overrides,
    )
    return run_in_process(load_scenario("flock_acoustic", duration_s=20.0, overrides=overrides, seed=4))


def last_headings_rad(recording):
    return [heading_from_quaternion(tuple(q)) for q in recording.attitude_quat_wxyz[-1].tolist()]


def test_with_no_packet_the_heading_of_the_path_changes_no_follower():
    one, other = (flight_of(heading_rad, DEAF) for heading_rad in (0.5, 2.0))
    for name in ARRAYS:
        a, b = getattr(one, name), getattr(other, name)
        assert np.array_equal(a[:, 1:], b[:, 1:]), name
    assert last_headings_rad(one)[0] == pytest.approx(0.5, abs=0.1)
    assert last_headings_rad(other)[0] == pytest.approx(2.0, abs=0.1)


def test_with_packets_the_flock_turns_to_the_heading_of_its_leader():
    half_step_rad = 0.5 * np.pi / 64.0
    assert last_headings_rad(flight_of(1.0)) == pytest.approx([1.0] * 4, abs=0.05 + half_step_rad)


def test_in_continuous_time_followers_turn_after_their_leader():
    overrides = ("vehicles.count=3", "leaders=[auv_2]", "reference.params.heading_rad=1.0")
    recording = run_continuous(load_scenario("swarm", duration_s=20.0, overrides=overrides))
    assert last_headings_rad(recording) == pytest.approx([1.0] * 3, abs=0.05)
