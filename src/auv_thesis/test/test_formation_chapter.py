"""Claims about the chapter on formations: its law is that of chapter 3, its numbers are those expected."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.controllers import MotionView
from auv_control.controllers.adaptive import Controller, Params
from auv_control.formations.frame import Course, Offset, world_offset
from auv_control.formations.references import Weights
from auv_control.references import PathPoint
from auv_core.geometry import quaternion_from_heading
from auv_core.messages import VehicleState
from auv_core.models import four_dof
from auv_thesis.formation import cases, stability
from auv_thesis.formation.law import Law, acceleration, wrench
from auv_thesis.formation.manoeuvre_cases import SWITCHES, straight_separation_m, switch_numbers
from auv_thesis.formation.manoeuvres import _EXPECTED_SEPARATION_M
from auv_thesis.formation.team import Plan, Setting, fly, straight, world_offsets
from auv_thesis.items import AGREES

MODERATE = settings(max_examples=40, deadline=None)
small = st.floats(-1.5, 1.5)
threes = st.tuples(small, small, small)
fours = st.tuples(*(4 * [small]))


@MODERATE
@given(fours, fours, fours, fours, fours, st.floats(0.3, 2.0))
def test_the_law_is_the_corrected_one_of_chapter_3(eta, nu, place, rate, change, ratio):
    controller = Controller(Params(blend_s=0.0, box=False, initial_ratio=ratio), 0.1)
    position, velocity = eta[:3], (nu[0], nu[1], nu[2], 0.0, 0.0, nu[3])
    nav = VehicleState(0, position, quaternion_from_heading(eta[3]), velocity)
    path = PathPoint(place[:3], rate[:3], change[:3], place[3], rate[3], change[3])
    view = MotionView(0.0, nav, path)
    tau, rates = controller.evaluate(controller.initial_state(view), view)
    law = Law(initial_ratio=ratio, adapts=True)
    wanted = np.array([place]), np.array([rate]), np.array([change])
    forces, direction = wrench(law, np.array([eta]), np.array([nu]), wanted, law.estimates[None])
    assert forces[0] == pytest.approx([tau[0], tau[1], tau[2], tau[5]], rel=1e-9, abs=1e-6)
    assert -law.adaptation * direction[0] == pytest.approx(rates, rel=1e-9, abs=1e-6)


@MODERATE
@given(fours, st.tuples(*(4 * [st.floats(-500.0, 500.0)])))
def test_the_plant_is_the_four_dof_model(nu, tau):
    law = Law()
    params = four_dof.Params(tuple(law.inertia), tuple(law.linear), tuple(law.quadratic))
    state = (0.0,) * 3 + (1.0, 0.0, 0.0, 0.0, nu[0], nu[1], nu[2], 0.0, 0.0, nu[3])
    rates = four_dof.Model(params).derivative(state, (*tau[:3], 0.0, 0.0, tau[3]), (0.0, 0.0, 0.0))
    ours = acceleration(law, np.array([nu]), np.array([tau]))[0]
    assert ours == pytest.approx([rates[7], rates[8], rates[9], rates[12]], rel=1e-9, abs=1e-9)


@MODERATE
@given(
    st.tuples(small, small, small), st.tuples(small, small, small), small, small, small, st.floats(1.0, 9.0)
)
def test_offsets_over_arrays_are_those_of_one_vehicle(before, after, chi, rate, change, t_s):
    weights = Weights(np.zeros((1, 1)), np.ones(1))
    plan = Plan(np.array([before]), np.array([after]), weights, 0.0, 10.0)
    course = Course(chi, rate, change)
    slot = Offset(*(tuple(rows[0].tolist()) for rows in plan.offsets(t_s)))
    for ours, one in zip(world_offsets(plan, course, t_s), world_offset(slot, course), strict=True):
        assert ours[0] == pytest.approx(one, abs=1e-12)


def test_a_team_in_its_slots_stays_there():
    flight = fly(Setting((cases.column(4, cases.TYPES["predecessor"]),), straight(0.5), 5.0))
    errors = flight.positions - flight.offsets - flight.path[:, None]
    assert np.abs(errors).max() < 1e-12


@pytest.mark.parametrize(("shapes", "expected_m"), list(zip(SWITCHES, _EXPECTED_SEPARATION_M, strict=True)))
def test_straight_ways_keep_the_expected_distance(shapes, expected_m):
    assert straight_separation_m(*shapes) == pytest.approx(expected_m, abs=0.006)


@pytest.mark.slow
def test_string_stability_is_as_expected():
    assert {row.verdict for row in stability.TABLES[0].rows([])} == {AGREES}
    assert cases.strings()["predecessor", 8].gamma == pytest.approx(1.045, abs=0.01)


@pytest.mark.slow
def test_mesh_stability_is_as_expected():
    assert {row.verdict for row in stability.TABLES[1].rows([])} == {AGREES}


@pytest.mark.slow
def test_a_switch_takes_as_long_as_expected():
    numbers = switch_numbers("column", "wedge", "straight")
    assert numbers.switch_s == pytest.approx(55.5, abs=1.5)
    assert numbers.separation_m == pytest.approx(8.165, abs=0.02)
    assert numbers.force_n < 1145.0
    assert math.isfinite(numbers.switch_s)
