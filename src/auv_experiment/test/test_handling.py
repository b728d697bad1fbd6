"""Claims: what a run says of hulls follows from their vehicles, whether they hover or not."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_core.models import Handling, hovering
from auv_experiment.metrics.courses.effort import fin_effort_metrics
from auv_experiment.metrics.safety import near_metrics, surface_metrics, warnings
from auv_experiment.recording import Recording
from auv_experiment.report.verdicts import verdicts
from auv_experiment.scenario.loading import load_scenario

REMUS = Handling(can_stop=False, least_speed_mps=0.8, hull_length_m=1.6, hull_diameter_m=0.19, near_m=5.0)
ANGLE = st.floats(-math.pi, math.pi)


def at(*places: tuple[float, float, float]) -> Recording:
    recording = Recording.empty([f"auv_{i}" for i in range(1, len(places) + 1)], np.array([0.0, 0.1]))
    recording.position_ned_m[:] = places
    recording.attitude_quat_wxyz[:] = (1.0, 0.0, 0.0, 0.0)
    return recording


def fleet(*handlings: Handling) -> Any:
    radii_m = tuple(handling.hull_radius_m for handling in handlings)
    return SimpleNamespace(
        handlings=handlings,
        hull_radii_m=radii_m,
        hull_radius_m=max(radii_m),
        agent=SimpleNamespace(flocking=None),
        vehicles=(),
    )


def height_m(handling: Handling, depth_m: float, quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)) -> Any:
    recording = at((0.0, 0.0, depth_m))
    recording.attitude_quat_wxyz[:] = quaternion
    return surface_metrics(recording, fleet(handling))["hull_in_air_height_m"]


def test_a_level_torpedo_is_in_the_air_as_soon_as_its_keel_is() -> None:
    assert height_m(REMUS, -0.09) is None
    assert height_m(REMUS, -0.295) == pytest.approx(0.2)


def test_a_torpedo_on_its_tail_reaches_half_its_length_down() -> None:
    on_its_tail = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
    assert height_m(REMUS, -0.79, on_its_tail) is None
    assert height_m(REMUS, -1.0, on_its_tail) == pytest.approx(0.2)


@given(angle_rad=ANGLE, axis_rad=ANGLE, tilt_rad=ANGLE)
def test_a_hull_reaches_down_between_its_radius_and_that_of_the_sphere_around_it(
    angle_rad: float, axis_rad: float, tilt_rad: float
) -> None:
    c, s = math.cos(0.5 * angle_rad), math.sin(0.5 * angle_rad)
    across = s * math.cos(tilt_rad)
    unit = (c, across * math.cos(axis_rad), across * math.sin(axis_rad), s * math.sin(tilt_rad))
    assert height_m(hovering(0.31), -0.5, unit) == 0.5 - 0.31
    assert 2.0 - 0.8 - 1e-9 <= height_m(REMUS, -2.0, unit) <= 2.0 - 0.095 + 1e-9


def test_two_torpedoes_that_pass_at_four_metres_are_too_near_and_do_not_touch() -> None:
    recording, scenario = at((0.0, 0.0, 30.0), (0.0, 4.0, 30.0), (0.0, 40.0, 30.0)), fleet(*3 * [REMUS])
    metrics: dict[str, Any] = {**near_metrics(recording, scenario)}
    assert metrics == {"near_pairs": 1, "near_pair_distance_min_m": 4.0}
    (line,) = warnings(metrics)
    assert line == "1 pair of vehicles came nearer to each other than near_m of their models, down to 4.00 m"
    answers = verdicts(scenario, {**metrics, "pair_distance_min_m": 4.0, "collision": False})
    assert any("Did vehicles keep their distance? <b>No.</b> 1 pair" in answer for answer in answers)
    assert any("hulls touch at 1.6 m" in answer for answer in answers)


def test_vehicles_apart_are_not_too_near() -> None:
    metrics = near_metrics(at((0.0, 0.0, 30.0), (0.0, 5.0, 30.0)), fleet(REMUS, REMUS))
    assert metrics == {"near_pairs": 0, "near_pair_distance_min_m": None}
    assert warnings(metrics) == []


def test_hovering_hulls_alone_state_no_such_distance() -> None:
    assert near_metrics(at((0.0, 0.0, 5.0), (0.0, 1.0, 5.0)), fleet(*2 * [hovering(0.31)])) == {}


def test_a_hovering_hull_beside_a_torpedo_keeps_the_distance_of_the_torpedo() -> None:
    recording, scenario = at((0.0, 0.0, 5.0), (0.0, 3.0, 5.0)), fleet(hovering(0.31), REMUS)
    assert near_metrics(recording, scenario)["near_pairs"] == 1
    (touch, *_) = verdicts(scenario, {"pair_distance_min_m": 3.0, "collision": False})
    assert "hulls touch at 1.11 m" in touch


def test_the_effort_of_fins_and_propellers_is_that_of_all_vehicles() -> None:
    scenario: Any = SimpleNamespace(
        vehicles=load_scenario("torpedo_fleet").vehicles[:2], period_s=0.1, kinematic=False
    )
    recording = at((0.0, 0.0, 30.0), (0.0, 20.0, 30.0))
    recording.actuator_output = np.full((2, 2, 3), np.nan)
    recording.actuator_output[1, 0] = (0.2, -0.1, 600.0)
    recording.actuator_output[1, 1] = (0.0, 0.1, 1200.0)
    metrics = fin_effort_metrics(recording, scenario)
    assert metrics["fin_effort_rad2s"] == pytest.approx(0.1 * (0.04 + 0.01 + 0.01))
    assert metrics["propeller_turns"] == pytest.approx(0.1 * 1800.0 / 60.0)
