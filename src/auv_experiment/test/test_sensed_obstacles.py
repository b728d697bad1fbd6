"""Claims about obstacles that no vehicle knows before: a vehicle that senses one avoids it, others do not."""

from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context

from auv_core.params import ConfigError
from auv_experiment.figures.flock import flock_drawers
from auv_experiment.figures.plotting import PAGE_STYLE
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.distances import obstacle_distances_m, obstacle_positions_ned_m
from auv_experiment.scenario.loading import load_scenario

STILL = "{position_ned_m: [6.0, 0.0, 10.0], known: false}"
OPPOSITE = (
    "{position_ned_m: [12.0, 0.0, 10.0], known: false, "
    "motion: {kind: straight, params: {velocity_ned_mps: [-0.1, 0.0, 0.0]}}}"
)
GENTLE = "agent.flocking.params.steering_limit_mps=0.05"
HIT_M = 0.31
"""The hull's radius: nearer than this, an obstacle is in the hull."""


def _alone_towards(obstacle: str, *overrides: str) -> Any:
    """Return a scenario of one vehicle whose path leads through an obstacle."""
    return load_scenario(
        "flock_sensed",
        overrides=[
            "vehicles=[{id: auv_1, model: {preset: odin}, position_ned_m: [0.0, 0.0, 10.0]}]",
            "reference={kind: line}",
            f"environment.obstacles=[{obstacle}]",
            *overrides,
        ],
        duration_s=100.0,
    )


def _clearance_m(scenario: Any) -> float:
    return float(obstacle_distances_m(run_in_process(scenario), scenario).min())


@pytest.mark.parametrize("obstacle", [STILL, OPPOSITE], ids=["still", "comes"])
def test_a_vehicle_avoids_what_it_senses_and_hits_what_it_cannot_sense(obstacle: str) -> None:
    assert _clearance_m(_alone_towards(obstacle, GENTLE)) > 1.0
    for blind in ("acoustics.sonar={kind: none}", "agent.obstacle_tracker={kind: none}"):
        assert _clearance_m(_alone_towards(obstacle, GENTLE, blind)) < HIT_M


def test_a_leader_that_steers_as_fast_as_it_may_retreat_does_not_avoid_what_comes_head_on() -> None:
    assert _clearance_m(_alone_towards(OPPOSITE)) < HIT_M


def test_every_separation_law_and_the_thesis_law_avoid_what_they_sense() -> None:
    for law in ("agent.separation={kind: fuzzy}", "agent.separation={kind: adaptive_fuzzy}"):
        assert _clearance_m(_alone_towards(STILL, law)) > 1.0
    thesis = "agent.flocking={kind: potential, params: {correction_limit_mps: 0.25}}"
    assert _clearance_m(_alone_towards(STILL, thesis)) > HIT_M


def test_a_path_law_avoids_what_it_senses() -> None:
    def clearance_m(tracker: str) -> float:
        obstacle = "{position_ned_m: [3.0, 9.6, 0.0], safety_distance_m: 2.0, known: false}"
        return _clearance_m(
            load_scenario(
                "ch2_pfpd_obstacles_corrected",
                overrides=[
                    "sampling=sampled",
                    f"environment.obstacles=[{obstacle}]",
                    "agent.controller.params.obstacle_gain_nm=200.0",
                    "agent.controller.params.truncate_repulsion=true",
                    "acoustics.sonar={kind: active}",
                    f"agent.obstacle_tracker={{kind: {tracker}}}",
                ],
                duration_s=60.0,
            )
        )

    assert clearance_m("none") < HIT_M < 1.0 < clearance_m("kalman")


def test_known_obstacles_count_as_before_to_the_bit_with_a_tracker_that_sees_nothing() -> None:
    plain = load_scenario("flock_acoustic", duration_s=20.0)
    tracking = load_scenario(
        "flock_acoustic", overrides=["agent.obstacle_tracker={kind: kalman}"], duration_s=20.0
    )
    first, second = run_in_process(plain), run_in_process(tracking)
    assert (first.command == second.command).all()
    assert (first.position_ned_m == second.position_ned_m).all()


def test_a_moving_obstacle_is_measured_and_drawn_where_it_is_at_the_time() -> None:
    scenario = _alone_towards(OPPOSITE, "agent.hold_s=0.0")
    recording = run_in_process(scenario)
    track_m = obstacle_positions_ned_m(recording, scenario)[:, 0, 0]
    np.testing.assert_allclose(track_m, 12.0 - 0.1 * recording.t_s, atol=1e-12)
    with rc_context(PAGE_STYLE):
        drawn = {name: draw() for name, draw in flock_drawers(recording, scenario).items()}
    assert drawn["obstacle_distances"] is not None
    plan = drawn["plan"]
    assert plan is not None
    assert "moving obstacle" in plan.caption


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (
            ["environment.obstacles=[{position_ned_m: [6.0, 0.0, 10.0], motion: {kind: shuttle}}]"],
            "environment.obstacles[0].known: True is not allowed",
        ),
        (
            ["environment.obstacles=[{position_ned_m: [6.0, 0.0, 9.0], motion: {kind: jump}}]"],
            "environment.obstacles[0].motion.kind",
        ),
    ],
)
def test_an_impossible_obstacle_is_refused_in_one_line(overrides: list[str], words: str) -> None:
    with pytest.raises(ConfigError) as error:
        load_scenario("flock_sensed", overrides=overrides)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_in_continuous_time_every_obstacle_must_be_known() -> None:
    unknown = "environment.obstacles=[{position_ned_m: [8.0, 5.0, 10.0], known: false}]"
    with pytest.raises(ConfigError, match=r"every environment\.obstacles is known"):
        load_scenario("ch5_obstacles", overrides=[unknown])
