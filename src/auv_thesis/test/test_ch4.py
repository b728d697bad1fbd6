"""
Chapter 4 in numbers: three spheres steer to a ring, and what each part of the law is for.

The numbers are those of an independent prototype of the same equations (adaptive Runge-Kutta, continuous
time); the thesis gives none. Tolerances are 0.01 m and 0.1 s.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.metrics.lyapunov import lyapunov_metrics
from auv_experiment.metrics.region import region_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.ch4_6 import ch4_claims
from auv_thesis.ch4_6.ch4_runs import LIMITED_STARTS, LONG_STARTS, STARTS, corner_starts
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART

M, S = 0.01, 0.1
PRINTED_LAYERS = "agent.controller.params.layer_gains_pm3=[0.1,0.1]"
COARSE = ("dt_s=0.02", "period_s=0.02")
CASE_A = tuple(
    f"vehicles.{i}.position_ned_m={start}"
    for i, start in enumerate(([20.0, 20.0, 20.0], [5.0, 0.0, 0.0], [20.0, 0.0, 5.0]))
)
MINUTE = "duration_s=60.0"


def _all_vehicles(key, value):
    return [f"vehicles.{i}.model.params.{key}={value}" for i in range(3)]


def _law(key, value):
    return f"agent.controller.params.{key}={value}"


def _fly(*overrides, name="ch4_region"):
    scenario = load_scenario(name, overrides=overrides)
    recording = run_in_process(scenario)
    closest_m = pair_distances_m(recording).min()
    return region_metrics(recording, scenario) | {
        "pair_distance_min_m": closest_m,
        **lyapunov_metrics(recording, scenario),
    }


def _check_table_row(metrics, closest, first_inside_s, reached_s):
    assert metrics["pair_distance_min_m"] == pytest.approx(closest[0], abs=M)
    assert metrics["pair_distance_min_at_s"] == pytest.approx(closest[1], abs=S)
    assert metrics["ring_first_inside_s"] == pytest.approx(first_inside_s, abs=S)
    assert metrics["ring_reached_s"] == pytest.approx(reached_s, abs=S)


def test_default_case():
    metrics = _fly()
    _check_table_row(metrics, (0.973, 8.35), [1.62, 1.62, 2.16], [29.72, 29.72, 30.09])
    final = [(9.69, 11.68, 10.45), (9.42, 8.26, 9.55), (11.82, 10.52, 10.39)]
    np.testing.assert_allclose(metrics["position_final_ned_m"], final, atol=M)
    assert metrics["axis_distance_final_m"] == pytest.approx([1.71, 1.83, 1.89], abs=M)
    assert metrics["ring_distance_final_m"] == [0.0, 0.0, 0.0]
    assert metrics["force_max_n"] == pytest.approx(18.3e3, abs=100.0)
    assert metrics["speed_max_mps"] == pytest.approx(16.0, abs=0.1)
    assert metrics["lyapunov_energy_falls"]


def test_printed_layer_gains_let_them_collide():
    metrics = _fly(PRINTED_LAYERS, *CASE_A, *COARSE)
    _check_table_row(metrics, (0.566, 8.64), [1.62, 1.62, 10.17], [21.82, 21.82, 30.09])
    final = [(11.86, 11.62, 10.12), (8.03, 9.59, 9.88), (11.77, 8.23, 9.61)]
    np.testing.assert_allclose(metrics["position_final_ned_m"], final, atol=M)
    assert metrics["axis_distance_final_m"] == pytest.approx([2.47, 2.01, 2.50], abs=M)
    assert metrics["speed_max_mps"] == pytest.approx(21.8, abs=0.1)
    assert metrics["force_max_n"] == pytest.approx(32.1e3, abs=100.0)


def test_force_limit_of_a_real_vehicle():
    metrics = _fly(*COARSE, name="ch4_region_limited")
    assert metrics["pair_distance_min_m"] == pytest.approx(1.405, abs=M)
    assert metrics["ring_reached_s"] == pytest.approx([18.46, 18.46, 17.33], abs=S)
    assert metrics["speed_max_mps"] == pytest.approx(2.52, abs=0.02)


def test_without_gravity_compensation_they_hang_below_the_ring():
    metrics = _fly(PRINTED_LAYERS, _law("gravity_compensation", "false"), *COARSE)
    # k_p 2 k_l (dz^2 - h^2/4) dz = W - B has the root dz = 2.24 m, and each is 0.03 m from there after 80 s
    depths_m = np.array(metrics["position_final_ned_m"])[:, 2]
    np.testing.assert_allclose(depths_m, 12.235, atol=M)
    assert metrics["ring_reached_s"] == [None, None, None]
    assert min(metrics["ring_distance_final_m"]) > 1.7
    assert not metrics["lyapunov_energy_falls"]


@pytest.mark.slow
def test_printed_layer_gains_in_the_default_case():
    metrics = _fly(PRINTED_LAYERS)
    _check_table_row(metrics, (0.801, 8.90), [1.62, 1.62, 2.16], [21.56, 21.60, 30.22])
    final = [(8.22, 9.62, 10.10), (10.43, 8.05, 9.90), (11.85, 10.53, 10.39)]
    np.testing.assert_allclose(metrics["position_final_ned_m"], final, atol=M)
    assert metrics["axis_distance_final_m"] == pytest.approx([1.82, 1.99, 1.93], abs=M)


@pytest.mark.slow
def test_stronger_layers_in_the_other_case():
    metrics = _fly(*CASE_A)
    _check_table_row(metrics, (0.950, 8.03), [1.62, 1.62, 10.17], [23.29, 18.96, 38.48])
    final = [(12.11, 8.67, 9.85), (8.93, 11.47, 10.01), (11.47, 8.04, 10.47)]
    np.testing.assert_allclose(metrics["position_final_ned_m"], final, atol=M)


@pytest.mark.slow
def test_without_drag_they_nearly_meet_and_take_longer():
    metrics = _fly(PRINTED_LAYERS, *_all_vehicles("quadratic_damping", [0.0] * 6))
    assert metrics["pair_distance_min_m"] == pytest.approx(0.10, abs=M)
    assert [round(reached_s) for reached_s in metrics["ring_reached_s"]] == [51, 52, 40]


@pytest.mark.slow
def test_without_any_damping_they_never_settle():
    overrides = [*_all_vehicles("quadratic_damping", [0.0] * 6), _law("damping_gain", [0.0] * 6)]
    metrics = _fly(PRINTED_LAYERS, *overrides)
    assert metrics["ring_reached_s"] == [None, None, None]
    assert metrics["speed_max_mps"] > 20.0


@pytest.mark.slow
def test_much_damping_makes_them_creep():
    metrics = _fly(PRINTED_LAYERS, _law("damping_gain", [300.0] * 6), MINUTE, *COARSE)
    errors_m = np.abs(np.array(metrics["position_final_ned_m"])[:, 2] - 10.0)
    np.testing.assert_allclose(errors_m, 0.6, atol=M)
    assert metrics["ring_reached_s"] == [None, None, None]


@pytest.mark.slow
@pytest.mark.parametrize(
    "overrides",
    [
        _all_vehicles("added_mass", [0.0] * 6),
        _all_vehicles("quadratic_damping", [66.5, 66.5, 66.5, 80.0, 80.0, 80.0]),
        _all_vehicles("cog_couples", "true"),
    ],
    ids=["no added mass", "more drag", "z_G in M"],
)
def test_what_the_thesis_does_not_say_of_the_hull_does_not_matter(overrides):
    metrics = _fly(PRINTED_LAYERS, *overrides)
    assert max(metrics["ring_distance_final_m"]) <= 0.05
    assert None not in metrics["ring_reached_s"]


@pytest.mark.slow
@pytest.mark.parametrize(("gains", "low", "high"), [([100.0, 500.0], 0.0, 0.1), ([10.0, 50.0], 0.6, 0.95)])
def test_how_often_random_groups_collide(gains, low, high):
    # The prototype's 200 starts: 0.02 and 0.80. These are 40, near corners of the box drawn in Figs 4.5-4.6.
    collisions = 0
    for starts in corner_starts(1, 40):
        overrides = [*COARSE, *starts, _law("layer_gains_pm3", gains), "duration_s=12.0"]
        recording = run_in_process(load_scenario("ch4_region", overrides=overrides))
        collisions += bool(pair_distances_m(recording).min() < 0.6)
    assert low <= collisions / 40 <= high


def _arrived(reached_s, *, collision):
    return SimpleNamespace(
        metrics={
            "ring_reached_s": reached_s,
            "collision": collision,
            "pair_distance_min_m": 0.3 if collision else 1.0,
            "force_max_n": 200.0,
            "speed_max_mps": 2.0,
        }
    )


@pytest.mark.parametrize(
    ("reached_s", "printed_collide", "verdict"),
    [([1.0, 2.0], False, HOLDS), ([1.0, 2.0], True, HOLDS_IN_PART), ([1.0, None], False, DOES_NOT_HOLD)],
)
def test_a_vehicle_that_hit_another_has_not_steered_to_safety(reached_s, printed_collide, verdict):
    whole = [_arrived(reached_s, collision=False)] * (2 + LONG_STARTS + LIMITED_STARTS)
    printed = [_arrived([None], collision=printed_collide)] * STARTS
    assert ch4_claims._judge_arrival([*whole, *printed]).holds == verdict


def test_gains_that_were_chosen_to_be_safe_do_not_make_the_claim_hold():
    ours = [_arrived([1.0], collision=False)] * (1 + STARTS)
    printed = [_arrived([1.0], collision=True)] * STARTS
    limited = [_arrived([1.0], collision=False)] * LIMITED_STARTS
    verdict = ch4_claims._judge_collisions([*ours, *printed, *limited])
    assert verdict.holds == DOES_NOT_HOLD
    assert f"all {STARTS}" in verdict.evidence
    assert ch4_claims._judge_collisions([*ours, *ours[1:], *limited]).holds == HOLDS
