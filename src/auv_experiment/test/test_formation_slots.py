"""Claims about the error of a formation with slots, and about stability along its strings."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.params import ConfigError
from auv_experiment.metrics.formations.slots import formation_slot_metrics, plan_of
from auv_experiment.metrics.formations.stability import (
    LEADER,
    decay_rate_ps,
    formation_error_m,
    gains_along_string,
    gains_from_leader,
    gains_over_layers,
    least_distance_m,
    root_of_integral,
    settled_after_s,
    spacing_errors_m,
    stacked_m,
    sup,
    target_errors,
)
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario

MODERATE = settings(max_examples=40, deadline=None)
COLUMN = (LEADER, 0, 1, 2)
OFFSETS = np.array([[(-4.0 * i, 0.0, 0.0) for i in range(4)]])
shifts = st.tuples(*(3 * [st.floats(-5.0, 5.0)]))


@MODERATE
@given(shifts)
def test_a_formation_that_is_elsewhere_as_a_whole_has_no_error(shift):
    positions = OFFSETS + np.array(shift)
    assert formation_error_m(positions, OFFSETS) == pytest.approx([0.0], abs=1e-12)
    errors = spacing_errors_m(positions, np.zeros((1, 3)), OFFSETS, COLUMN)
    assert errors[0] == pytest.approx([math.hypot(*shift), 0.0, 0.0, 0.0], abs=1e-12)


@MODERATE
@given(st.integers(1, 3), shifts)
def test_a_vehicle_out_of_its_slot_counts_for_itself_and_the_one_behind(index, shift):
    positions = OFFSETS.copy()
    positions[0, index] += shift
    size_m = math.hypot(*shift)
    assert formation_error_m(positions, OFFSETS) == pytest.approx([size_m / 2.0], abs=1e-9)
    errors = spacing_errors_m(positions, np.zeros((1, 3)), OFFSETS, COLUMN)[0]
    expected = [size_m if j in (index, index + 1) else 0.0 for j in range(4)]
    assert errors == pytest.approx(expected, abs=1e-9)


def test_gains_are_ratios_to_the_vehicle_ahead_and_to_the_leader():
    sizes = np.array([2.0, 1.0, 1.5, 0.75])
    assert gains_along_string(sizes, COLUMN) == [1.5, 0.5]
    assert gains_from_leader(sizes, COLUMN) == [0.5, 0.75, 0.375]
    assert gains_along_string(np.array([2.0, 1e-4, 1.5, 0.75]), COLUMN) == [0.5]
    assert gains_from_leader(1e-4 * sizes, COLUMN) == []


@MODERATE
@given(st.lists(st.floats(0.2, 2.0), min_size=3, max_size=3))
def test_a_column_is_a_mesh_with_one_vehicle_in_each_layer(ratios):
    steps = np.cumprod([1.0, *ratios])
    errors = np.zeros((2, 5, 3))
    errors[1, 1:, 0] = np.cumsum(steps)
    column = (LEADER, 0, 1, 2, 3)
    ahead = [() if j == LEADER else (j,) for j in column]
    sizes = sup(spacing_errors_m(errors, np.zeros((2, 3)), np.zeros_like(errors), column))
    assert gains_over_layers(errors, ahead) == pytest.approx(ratios)
    assert gains_along_string(sizes, column) == pytest.approx(ratios)


def test_a_layer_has_the_largest_error_of_its_vehicles():
    square = [(), (0,), (0,), (1, 2)]  # 0 leads, 1 and 2 follow it, 3 follows both
    errors = np.zeros((1, 4, 3))
    errors[0, 1:, 0] = (1.0, -3.0, 1.0)
    assert gains_over_layers(errors, square) == pytest.approx([4.0 / 3.0])


@MODERATE
@given(shifts)
def test_followers_of_others_have_no_own_error_where_those_would_have_them(shift):
    errors = np.zeros((1, 3, 3))
    errors[0] += np.array(shift)
    half = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5, 0.0]])
    assert stacked_m(target_errors(errors, half)) == pytest.approx([0.0], abs=1e-12)
    errors[0, 2] += np.array((3.0, 4.0, 0.0))
    assert stacked_m(target_errors(errors, half)) == pytest.approx([5.0])


def test_norms_of_errors():
    errors = np.array([[3.0, 0.0], [4.0, 1.0]])
    assert sup(errors).tolist() == [4.0, 1.0]
    assert root_of_integral(errors, 0.25).tolist() == [2.5, 0.5]


def test_settling_and_decay():
    t_s = np.linspace(0.0, 10.0, 101)
    errors = np.exp(-0.5 * t_s)
    assert decay_rate_ps(t_s, errors) == pytest.approx(0.5)
    assert settled_after_s(t_s, errors, 0.1) == pytest.approx(2.0 * math.log(10.0), abs=0.1)
    assert settled_after_s(t_s, errors, 2.0) == -math.inf
    assert settled_after_s(t_s, errors, 1e-3) == math.inf
    assert least_distance_m(OFFSETS) == 4.0
    assert least_distance_m(OFFSETS[:, :1]) == math.inf


def recording_of(scenario, positions):
    ids = [vehicle.id for vehicle in scenario.vehicles]
    recording = Recording.empty(ids, scenario.tick_times())
    recording.position_ned_m[:] = positions
    return recording


def formation_of(scenario):
    """Return the parameters of the formation law."""
    assert scenario.agent.flocking is not None
    return scenario.agent.flocking.params


def test_a_fleet_on_its_plan_has_no_error_and_a_lost_vehicle_does_not_count():
    scenario = load_scenario("formation_repair", duration_s=250.0, overrides=("period_s=1.0",))
    recording = recording_of(scenario, 0.0)
    params = formation_of(scenario)
    plan = plan_of(recording, scenario, params)
    assert plan.changed_at_s == 140.0
    assert set(np.flatnonzero(np.isnan(plan.offsets[-1, :, 0])).tolist()) == {0, 3}
    assert plan.followed[1] == LEADER
    positions = np.nan_to_num(plan.offsets) + 7.0
    metrics = formation_slot_metrics(recording_of(scenario, positions), scenario, 10.0)
    assert metrics["formation_error_rms_m"] == pytest.approx(0.0, abs=1e-9)
    assert metrics["formation_error_final_m"] == pytest.approx(0.0, abs=1e-9)
    assert metrics["formation_in_place_after_s"] == 0.0
    for key in ("string_gain_max", "mesh_gain_max", "leader_to_formation_gain_s"):
        assert metrics[key] is None


def test_agreement_counts_from_the_last_live_vehicle_that_holds_the_slots_of_the_live_ones():
    scenario = load_scenario("formation_repair", duration_s=200.0, overrides=("period_s=1.0",))
    recording = recording_of(scenario, 0.0)
    assert formation_slot_metrics(recording, scenario, 0.0)["formation_agreed_after_s"] is None
    plan = plan_of(recording, scenario, formation_of(scenario))
    assert [plan.slots[i] for i in (0, 3)] == [-1.0, -1.0]
    recording.law_state = np.full((recording.n_ticks, 8, 8), 7.0)
    recording.law_state[145:] = plan.slots
    recording.law_state[150, 5] = 7.0
    recording.law_state[160:, 3] = 7.0  # a lost one does not count
    assert formation_slot_metrics(recording, scenario, 0.0)["formation_agreed_after_s"] == 150.0


def test_lost_vehicles_may_be_near_others():
    scenario = load_scenario("formation_repair", duration_s=120.0, overrides=("period_s=1.0",))
    positions = np.zeros((121, 8, 3))
    positions[:, :, 1] = 4.0 * np.arange(8)
    positions[101:, 4] = positions[101:, 3]
    metrics = formation_slot_metrics(recording_of(scenario, positions), scenario, 0.0)
    assert metrics["pair_distance_working_min_m"] == pytest.approx(4.0)


def test_a_string_has_a_gain_and_another_law_has_none_of_these():
    scenario = load_scenario("formation_string", duration_s=40.0, overrides=("period_s=1.0",))
    plan = plan_of(recording_of(scenario, 0.0), scenario, formation_of(scenario))
    positions = plan.offsets.copy()
    for vehicle in range(1, 8):
        positions[20, vehicle:, 0] += 0.1 * 1.2**vehicle
    metrics = formation_slot_metrics(recording_of(scenario, positions), scenario, 10.0)
    assert metrics["string_gain_max"] == pytest.approx(1.2)
    assert metrics["mesh_gain_max"] == pytest.approx(1.2)
    assert metrics["string_gain_l2_max"] == pytest.approx(1.2)
    assert metrics["string_gain_leader_max"] == pytest.approx(0.1 * 1.2**7 / 15.0)  # depth of the path
    assert metrics["leader_to_formation_gain_s"] is None
    other = load_scenario("flock_modem", duration_s=10.0)
    assert formation_slot_metrics(recording_of(other, 0.0), other, 0.0) == {}


def test_the_gain_from_the_leader_is_per_change_of_its_speed():
    scenario = load_scenario("formation_string", duration_s=60.0, overrides=("period_s=1.0",))
    plan = plan_of(recording_of(scenario, 0.0), scenario, formation_of(scenario))
    positions = plan.offsets.copy()
    positions[50, 1:, 0] -= 0.6  # all followers behind the leader, each in its place behind the next
    metrics = formation_slot_metrics(recording_of(scenario, positions), scenario, 0.0)
    assert metrics["leader_to_formation_gain_s"] == pytest.approx(0.6 / 0.3)


def test_a_formation_that_cannot_be_is_refused_at_load():
    with pytest.raises(
        ConfigError, match=r"^scenario\.agent\.flocking\.params\.shape: 'column' is not allowed"
    ):
        load_scenario(
            "formation_string", overrides=("agent.flocking={kind: bearing, params: {shape: column}}",)
        )
    with pytest.raises(ConfigError, match=r"params\.offsets_m: those of 1 vehicles are not allowed"):
        load_scenario(
            "formation_string",
            overrides=("agent.flocking={kind: displacement, params: {offsets_m: [0.0, 0.0, 0.0]}}",),
        )
