"""Claims about the formation law by displacements, and about what a vehicle makes of silence."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.formations.shapes import SHAPES, shape_slots
from auv_control.references import PathPoint
from auv_core.params import ConfigError, load
from auv_flocking.flocking import NOTHING_HEARD, FlockVelocity, Member, View
from auv_flocking.flocking.displacement import Flocking, Params
from auv_flocking.heard import bit_of
from auv_flocking.neighbours.estimates import Estimates, NeighbourEstimate
from auv_flocking.separation import mathematical

MODERATE = settings(max_examples=30, deadline=None)
D_M, FLEET = 4.0, 6
PATH = PathPoint((100.0, 50.0, 20.0), (0.3, 0.0, 0.0))
EXACT = np.eye(6) * 1e-6
SEPARATION = mathematical.Separation(mathematical.Params())


def law_of(address, **changes):
    return Flocking(Params(**changes), SEPARATION, Member(address == 1, address, FLEET))


def place_of(slot):
    return tuple(p + o for p, o in zip(PATH.position, slot, strict=True))


def estimate(address, place, *, t_s=0.0, age_s=0.0, mask=0, within_s=1.0, turn=0.0):
    return NeighbourEstimate(
        address,
        place,
        PATH.velocity,
        EXACT,
        age_s,
        place,
        PATH.velocity,
        t_s - age_s,
        time_s=t_s - age_s,
        heard_within_s=within_s,
        heard_mask=mask,
        flock_turn_rate_radps=turn,
    )


def commanded(law, own, estimates, t_s=0.0, belief=NOTHING_HEARD):
    """Return the velocity and the estimate of the flock's velocity after one step."""
    rows = Estimates.of(estimates)
    law.hear(rows, 1.0)
    belief = law.flock_velocity(t_s, PATH, own, belief, rows)
    view = View(own, own, belief.at(t_s), rows.positions(), (), PATH, rows)
    return law.velocity(view), belief


def others_in_place(address, slots, **details):
    return [
        estimate(other, place_of(slots[other - 1]), **details)
        for other in range(1, FLEET + 1)
        if other != address
    ]


@MODERATE
@given(st.sampled_from(SHAPES), st.integers(1, FLEET), st.integers(0, 2))
def test_in_its_place_a_vehicle_moves_with_the_flock(shape, address, kind):
    shares = dict.fromkeys(("leader_share", "predecessor_share", "neighbour_share"), 0.0)
    shares[list(shares)[kind]] = 1.0
    slots = shape_slots(shape, FLEET, D_M)
    law = law_of(address, shape=shape, **shares)
    velocity, _ = commanded(law, place_of(slots[address - 1]), others_in_place(address, slots))
    assert velocity == pytest.approx(PATH.velocity, abs=1e-6)


@MODERATE
@given(st.integers(1, FLEET), st.tuples(*(3 * [st.floats(-0.4, 0.4)])))
def test_out_of_its_place_it_goes_back(address, away):
    slots = shape_slots("wedge", FLEET, D_M)
    place = tuple(p + a for p, a in zip(place_of(slots[address - 1]), away, strict=True))
    velocity, _ = commanded(law_of(address, shape="wedge"), place, others_in_place(address, slots))
    correction = np.subtract(velocity, PATH.velocity)
    assert correction == pytest.approx(-0.3 * np.array(away), abs=1e-6)


def test_old_information_lowers_the_gain():
    slots = shape_slots("column", FLEET, D_M)
    place = place_of((slots[3][0] + 0.4, 0.0, 0.0))
    velocity, _ = commanded(law_of(4), place, others_in_place(4, slots, t_s=10.0, age_s=10.0), t_s=10.0)
    assert PATH.velocity[0] - velocity[0] == pytest.approx(0.4 * 0.3 / 10.0, rel=1e-6)


def test_a_follower_does_not_use_the_path():
    slots = shape_slots("wedge", FLEET, D_M)
    law = law_of(3, shape="wedge")
    rows = Estimates.of(others_in_place(3, slots))
    law.hear(rows, 1.0)
    own = place_of(slots[2])
    answers = []
    for path in (PATH, PathPoint((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), heading_rad=2.0)):
        belief = law.flock_velocity(0.0, path, own, NOTHING_HEARD, rows)
        answers.append((belief, law.velocity(View(own, own, belief.at(0.0), (), (), path, rows))))
    assert answers[0] == answers[1]


def heard_of(lost, silent_for_s, t_s, address=2):
    """Return what vehicle 2 knows if some others are silent, and the rest heard each other just now."""
    slots = shape_slots("wedge", FLEET, D_M)
    alive = [a for a in range(1, FLEET + 1) if a not in lost]
    estimates = []
    for other in range(1, FLEET + 1):
        if other == address:
            continue
        mask = sum(bit_of(a) for a in alive if a != other)
        age_s = silent_for_s if other in lost else 0.0
        estimates.append(estimate(other, place_of(slots[other - 1]), t_s=t_s, age_s=age_s, mask=mask))
    return estimates


def test_silence_alone_makes_a_vehicle_lost_and_the_others_take_its_place():
    law = law_of(2, shape="wedge", lost_after_s=30.0)
    place = place_of(shape_slots("wedge", FLEET, D_M)[1])
    commanded(law, place, heard_of({1, 4}, 29.0, 51.0), 51.0)
    assert law.roster.live == (1, 2, 3, 4, 5, 6)
    commanded(law, place, heard_of({1, 4}, 31.0, 52.0), 52.0)
    assert law.roster.live == (2, 3, 5, 6)
    assert sorted(law.roster.order.slots.values()) == [0, 1, 2, 3]
    assert law.leads
    commanded(law, place, heard_of({1, 4}, 0.0, 53.0), 53.0)
    assert law.roster.live == (1, 2, 3, 4, 5, 6)


def test_news_at_second_hand_keep_a_vehicle_alive():
    law = law_of(2, shape="wedge", lost_after_s=30.0)
    estimates = [each._replace(heard_mask=each.heard_mask | bit_of(4)) for each in heard_of({4}, 40.0, 50.0)]
    commanded(law, place_of((0.0, 0.0, 0.0)), estimates, 50.0)
    assert law.roster.live == (1, 2, 3, 4, 5, 6)


def test_a_vehicle_that_hears_nothing_keeps_its_slot():
    law = law_of(2, shape="wedge", lost_after_s=30.0)
    for t_s in (40.0, 41.0, 42.0):
        commanded(law, place_of((0.0, 0.0, 0.0)), [], t_s)
    assert law.roster.live == (1, 2, 3, 4, 5, 6)


def test_a_new_leader_goes_on_with_the_last_velocity_and_its_turn():
    law = law_of(2, shape="wedge", lost_after_s=30.0)
    belief = FlockVelocity((0.3, 0.0, 0.0), 51.0, 0.01)
    place = place_of(shape_slots("wedge", FLEET, D_M)[1])
    _, belief = commanded(law, place, heard_of({1}, 30.0, 51.0), 51.0, belief)
    assert not law.leads
    _, after = commanded(law, place, heard_of({1}, 31.0, 52.0), 52.0, belief)
    assert law.leads
    assert after == FlockVelocity(belief.at(52.0), 52.0, belief.turn_rate_radps)


def test_the_shape_switches_at_its_time():
    law = law_of(6, shape="column", next_shape="line", switch_at_s=10.0, move_s=20.0)
    column, line = (shape_slots(shape, FLEET, D_M) for shape in ("column", "line"))
    for t_s in (8.0, 9.0):
        commanded(law, place_of(column[5]), others_in_place(6, column, t_s=t_s), t_s)
        assert law.roster.offset(6, t_s).position == column[5]
    commanded(law, place_of(column[5]), others_in_place(6, column, t_s=10.0), 10.0)
    commanded(law, place_of(column[5]), others_in_place(6, column, t_s=11.0), 11.0)
    assert law.roster.offset(6, 40.0).position in line


def test_a_lost_vehicle_ahead_is_passed_on_the_right():
    law = law_of(2, shape="column", lost_after_s=30.0)
    ahead, own = (110.0, 50.0, 20.0), (106.0, 50.0, 20.0)
    rest = [estimate(a, (50.0, 10.0 * a, 20.0), t_s=52.0) for a in (3, 4, 5, 6)]
    commanded(law, own, [estimate(1, ahead, t_s=11.0), *rest], 11.0)
    commanded(law, own, [estimate(1, ahead, t_s=52.0, age_s=41.0), *rest], 52.0)
    velocity, _ = commanded(law, own, [estimate(1, ahead, t_s=53.0, age_s=42.0), *rest], 53.0)
    assert law.roster.wrecks == (ahead,)
    assert velocity[1] > 0.1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"leader_share": 0.7}, r"flocking\.references: the shares"),
        ({"offsets_m": [0.0, 1.0]}, r"flocking\.offsets_m: 2 numbers are not allowed"),
        ({"spacing_m": 1.5}, r"flocking\.barrier_distance_m: 1\.3 is not allowed; allowed: less than"),
        ({"shape": "heap"}, r"flocking\.shape: 'heap' is not allowed; allowed: column, line"),
    ],
)
def test_a_formation_that_cannot_be_is_refused(changes, message):
    with pytest.raises(ConfigError, match=message):
        load(Params, changes, "flocking")


def test_own_offsets_are_one_for_each_vehicle():
    offsets = tuple(float(x) for i in range(FLEET) for x in (-5.0 * i, 2.0 * (i % 2), 0.0))
    law = law_of(2, offsets_m=offsets)
    assert law.roster.offset(2, 0.0).position == (-5.0, 2.0, 0.0)
    with pytest.raises(ValueError, match="offsets_m: those of 5 vehicles are not allowed"):
        law_of(2, offsets_m=offsets[:15])
    assert math.isfinite(Params(offsets_m=offsets).formation_spacing_m)
