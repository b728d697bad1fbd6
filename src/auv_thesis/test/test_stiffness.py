"""Laws are compared at equal stiffness: the gains follow from the laws' own functions."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.scenario.loading import load_scenario
from auv_flocking.separation import fuzzy
from auv_thesis.ch4_6.flock_runs import (
    ATTRACTION_PS,
    COARSE,
    EQUAL_FOUR_LEADERS,
    EQUAL_GAIN,
    FUZZY_FOUR_LEADERS,
    FUZZY_RESTS_AT_M,
    FUZZY_STIFFNESS_PS,
    drawn_starts,
)
from auv_thesis.ch4_6.stiffness import (
    equilibrium_m,
    gain_for_distance,
    gain_for_stiffness,
    mathematical_law,
    resting_stiffness_ps,
    stiffness_ps,
)
from auv_thesis.laws import separation_runs

D_M = 2.0


@given(st.floats(0.01, 100.0), st.floats(1.0, 1.99))
def test_stiffness_of_the_mathematical_law_is_its_derivative(gain, r_m):
    # v = 2 g (d^2 - r^2) / r^3
    expected = 2.0 * gain * (3.0 * D_M**2 / r_m**4 - 1.0 / r_m**2)
    assert stiffness_ps(mathematical_law(gain), r_m, D_M) == pytest.approx(expected, rel=1e-6)


@given(st.floats(2.0, 100.0), st.floats(0.3, 3.0), st.integers(2, 4))
def test_the_found_gain_has_the_wanted_stiffness(gain, attraction_ps, n):
    wanted_ps = resting_stiffness_ps(mathematical_law(gain), attraction_ps, n, D_M)
    assert gain_for_stiffness(wanted_ps, attraction_ps, n, D_M) == pytest.approx(gain, rel=1e-6)


@given(st.floats(0.5, 100.0), st.floats(0.3, 3.0), st.integers(2, 4))
def test_a_stiffer_law_rests_nearer_to_the_spacing(gain, attraction_ps, n):
    soft_m, stiff_m = (equilibrium_m(mathematical_law(g), attraction_ps, n, D_M) for g in (gain, 2.0 * gain))
    assert soft_m < stiff_m < D_M
    assert gain_for_distance(soft_m, attraction_ps, n, D_M) == pytest.approx(gain, rel=1e-6)


def test_the_printed_law_rests_where_the_thesis_says():
    assert equilibrium_m(mathematical_law(1.0), ATTRACTION_PS, 4, D_M) == pytest.approx(1.595, abs=1e-3)


def test_a_gain_of_20_4_holds_the_distance_of_the_fuzzy_law():
    assert pytest.approx(1.9590, abs=1e-4) == FUZZY_RESTS_AT_M
    assert gain_for_distance(FUZZY_RESTS_AT_M, ATTRACTION_PS, 4, D_M) == pytest.approx(20.4, abs=0.02)


def test_at_equal_stiffness_the_mathematical_flock_is_no_farther_from_d_and_never_nearer_together():
    def flown_m(spec):
        scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=30.0)
        return pair_distances_m(run_in_process(scenario))

    fuzzy_m, equal_m = flown_m(FUZZY_FOUR_LEADERS), flown_m(EQUAL_FOUR_LEADERS)
    assert resting_stiffness_ps(mathematical_law(EQUAL_GAIN), ATTRACTION_PS, 4, D_M) == pytest.approx(
        FUZZY_STIFFNESS_PS
    )
    assert D_M - equal_m[-1].min() < D_M - fuzzy_m[-1].min()
    assert fuzzy_m.min() < 1.3 < 1.9 < equal_m.min()


def test_the_scenarios_have_the_laws_that_the_gains_are_computed_for():
    for spec in (FUZZY_FOUR_LEADERS, EQUAL_FOUR_LEADERS):
        agent = load_scenario(spec.scenario, overrides=COARSE).agent
        assert agent.flocking is not None
        assert agent.separation is not None
        assert agent.flocking.params.spacing_m == D_M
        assert agent.flocking.params.cohesion_gain_ps == agent.flocking.params.path_gain_ps == 1.0
        if agent.separation.kind == "fuzzy":
            assert agent.separation.params == fuzzy.Params()


def test_the_flock_on_a_modem_is_pulled_by_cohesion_alone():
    for spec in separation_runs.RUNS.values():
        scenario = load_scenario(spec.scenario, overrides=spec.overrides)
        assert scenario.agent.flocking is not None
        law = scenario.agent.flocking.params
        assert (law.cohesion_gain_ps, law.followers, law.leader_steers) == (1.0, "blind", "centre")
        assert len(scenario.vehicles) == separation_runs.N_VEHICLES


def test_a_corrected_spacing_rests_at_d_with_the_stiffness_of_the_adaptive_law():
    law = mathematical_law(separation_runs.CORRECTED_GAIN)
    rest_m = equilibrium_m(law, separation_runs.ATTRACTION_PS, 4, separation_runs.WIDER_M)
    assert rest_m == pytest.approx(D_M)
    assert stiffness_ps(law, rest_m, separation_runs.WIDER_M) == pytest.approx(
        separation_runs.STIFFNESS_PS["adaptive fuzzy"]
    )


def test_drawn_starts_are_as_far_apart_as_the_axis_of_the_thesis():
    for overrides in drawn_starts(3, 5):
        scenario = load_scenario("ch5_four_leaders", overrides=(*COARSE, *overrides), duration_s=0.2)
        start_m = pair_distances_m(run_in_process(scenario))[0]
        assert 18.0 <= start_m.max() <= 20.0
        assert start_m.min() >= 3.0
    assert drawn_starts(3, 5) == drawn_starts(3, 5) != drawn_starts(4, 5)
