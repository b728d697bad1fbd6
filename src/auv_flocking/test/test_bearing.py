"""Claims about the formation law by bearings."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.formations.shapes import shape_slots
from auv_control.references import PathPoint
from auv_flocking.flocking import NOTHING_HEARD, Member, View
from auv_flocking.flocking.bearing import Flocking, Params, meeting_point
from auv_flocking.neighbours.estimates import Estimates, NeighbourEstimate
from auv_flocking.separation import mathematical

SEPARATION = mathematical.Separation(mathematical.Params())
MODERATE = settings(max_examples=40, deadline=None)
D_M, FLEET = 4.0, 6
PATH = PathPoint((100.0, 50.0, 20.0), (0.3, 0.0, 0.0))
shapes = st.sampled_from(["wedge", "diamond", "double_platoon"])


def estimate(address, place):
    return NeighbourEstimate(
        address, place, PATH.velocity, np.eye(6) * 1e-6, 0.0, place, PATH.velocity, 0.0, time_s=0.0
    )


def commanded(address, own, places, shape):
    law = Flocking(Params(shape=shape), SEPARATION, Member(address == 1, address, FLEET))
    rows = Estimates.of([estimate(a, p) for a, p in places.items() if a != address])
    law.hear(rows, 1.0)
    belief = law.flock_velocity(0.0, PATH, own, NOTHING_HEARD, rows)
    return law.velocity(View(own, own, belief.at(0.0), rows.positions(), (), PATH, rows))


def places_of(shape, scale=1.0):
    slots = shape_slots(shape, FLEET, D_M)
    return {
        a: tuple(p + scale * o for p, o in zip(PATH.position, slots[a - 1], strict=True))
        for a in range(1, FLEET + 1)
    }


@MODERATE
@given(shapes, st.integers(1, FLEET))
def test_in_its_place_a_vehicle_moves_with_the_flock(shape, address):
    places = places_of(shape)
    assert commanded(address, places[address], places, shape) == pytest.approx(PATH.velocity, abs=1e-6)


@MODERATE
@given(shapes, st.integers(3, FLEET), st.floats(0.8, 2.0))
def test_the_size_of_the_formation_does_not_count_for_bearings(shape, address, scale):
    places = places_of(shape, scale)
    assert commanded(address, places[address], places, shape) == pytest.approx(PATH.velocity, abs=1e-6)


def test_the_first_follower_sets_the_size():
    places = places_of("wedge", 1.05)
    velocity = commanded(2, places[2], places, "wedge")
    right = np.subtract(places_of("wedge")[2], places[2])
    assert np.subtract(velocity, PATH.velocity) == pytest.approx(0.3 * right, abs=1e-6)


@MODERATE
@given(shapes, st.integers(3, FLEET), st.tuples(*(3 * [st.floats(-0.4, 0.4)])))
def test_out_of_its_place_it_goes_back(shape, address, away):
    places = places_of(shape)
    own = tuple(p + a for p, a in zip(places[address], away, strict=True))
    correction = np.subtract(commanded(address, own, places, shape), PATH.velocity)
    assert correction == pytest.approx(-0.3 * np.array(away), abs=1e-6)


def test_bearings_on_one_line_meet_nowhere():
    own, ahead = (0.0, 0.0, 0.0), [(4.0, 0.0, 0.0), (8.0, 0.0, 0.0)]
    assert meeting_point(own, ahead, ahead) is None
    aside = [(4.0, 0.0, 0.0), (0.0, 4.0, 0.0)]
    assert meeting_point(own, aside, aside) == pytest.approx(own, abs=1e-12)


@pytest.mark.parametrize("shape", ["column", "line"])
def test_shapes_on_one_line_are_refused(shape):
    with pytest.raises(ValueError, match=f"shape: '{shape}' is not allowed; allowed: shapes whose slots"):
        Flocking(Params(shape=shape), SEPARATION, Member(False, 2, FLEET))
