"""Claims about the assignment of slots, its bound on distances, and the repair of a formation."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.formations.assignment import assigned_slots, least_separation_m, separation_bound_m
from auv_control.formations.repair import (
    Word,
    ages_of_news_s,
    elected_leader,
    live_addresses,
    repaired_slots,
)
from auv_control.formations.shapes import SHAPES, least_distance_m, shape_slots

MODERATE = settings(max_examples=100, deadline=None)
D_M = 10.0

clouds = st.integers(2, 7).flatmap(
    lambda n: st.tuples(
        *(
            st.lists(st.tuples(*(3 * [st.floats(-40.0, 40.0)])), min_size=n, max_size=n, unique=True)
            for _ in range(2)
        )
    )
)


def way_of(starts, slots, taken):
    return least_separation_m(starts, [slots[slot] for slot in taken])


@MODERATE
@given(clouds)
def test_vehicles_that_take_their_assigned_slots_keep_the_bound(cloud):
    starts, slots = cloud
    taken = assigned_slots(starts, slots)
    assert sorted(taken) == list(range(len(starts)))
    assert way_of(starts, slots, taken) >= separation_bound_m(starts, slots) - 1e-9


@MODERATE
@given(clouds, st.integers(0, 10**6))
def test_no_other_assignment_has_a_smaller_sum_of_squares(cloud, seed):
    starts, slots = cloud
    other = np.random.default_rng(seed).permutation(len(starts))

    def cost_m2(taken):
        return sum(math.dist(start, slots[slot]) ** 2 for start, slot in zip(starts, taken, strict=True))

    assert cost_m2(assigned_slots(starts, slots)) <= cost_m2(other) + 1e-9


@MODERATE
@given(clouds)
def test_the_least_separation_is_that_of_the_ways(cloud):
    starts, ends = (np.array(points) for points in cloud)
    shares = np.linspace(0.0, 1.0, 201)[:, None, None]
    ways = starts + shares * (ends - starts)
    sampled = min(least_distance_m(list(map(tuple, instant.tolist()))) for instant in ways)
    step_m = 2.0 * np.linalg.norm(ends - starts, axis=1).max() / 200.0
    assert sampled - step_m <= least_separation_m(starts.tolist(), ends.tolist()) <= sampled + 1e-9


def test_switching_between_shapes_keeps_the_bound():
    bounds = []
    for count in range(2, 9):
        shapes = [shape_slots(name, count, D_M) for name in SHAPES]
        for starts, slots in itertools.permutations(shapes, 2):
            bounds.append(way_of(starts, slots, assigned_slots(starts, slots)))
    assert min(bounds) >= D_M / math.sqrt(2.0) - 1e-9


def test_slots_in_the_order_of_indices_collide():
    full, column = shape_slots("wedge", 6, D_M), shape_slots("wedge", 5, D_M)
    live = [0, 1, 3, 4, 5]
    assert least_separation_m([full[i] for i in live], column) < 0.5 * D_M


def test_news_at_second_hand_count():
    heard_s = {2: 90.0, 3: 40.0}
    words = [Word(3, 90.0, 8.0), Word(4, 90.0, 16.0), Word(3, 40.0, 1.0), Word(2, 90.0, 60.0)]
    assert ages_of_news_s(100.0, heard_s, words) == {2: 10.0, 3: 18.0, 4: 26.0}


def test_a_vehicle_is_lost_after_the_time_out():
    ages_s = {2: 10.0, 3: 30.0, 4: 30.1}
    assert live_addresses(1, 5, ages_s, 20.0, 30.0) == (1, 2, 3, 5)
    assert live_addresses(1, 5, ages_s, 31.0, 30.0) == (1, 2, 3)
    assert live_addresses(4, 4, {}, 31.0, 30.0) == (4,)


def test_the_lowest_live_address_that_knows_the_path_leads():
    assert elected_leader((2, 3, 5), knows_path=(1, 3, 5)) == 3
    assert elected_leader((2, 3, 5), knows_path=(1,)) == elected_leader((2, 3, 5)) == 2


def losses_of_eight():
    """Return the live vehicles for all losses of one or two of eight."""
    for count in (1, 2):
        for lost in itertools.combinations(range(1, 9), count):
            yield [address for address in range(1, 9) if address not in lost]


@pytest.mark.parametrize("shape", SHAPES)
def test_live_vehicles_stay_apart_while_any_two_of_eight_are_replaced(shape):
    full = shape_slots(shape, 8, D_M)
    for live in losses_of_eight():
        after = shape_slots(shape, len(live), D_M)
        slots = repaired_slots(live, full, after)
        assert sorted(slots) == live
        assert sorted(slots.values()) == list(range(len(live)))
        way_m = least_separation_m([full[a - 1] for a in live], [after[slots[a]] for a in live])
        assert way_m >= D_M / math.sqrt(2.0) - 1e-9


def test_a_leader_that_keeps_its_slot_can_be_run_into():
    full, after = shape_slots("line", 8, D_M), shape_slots("line", 6, D_M)
    live = [1, 3, 5, 6, 7, 8]
    slots = repaired_slots(live[1:], full, after[1:])
    ends = [after[0], *(after[1 + slots[a]] for a in live[1:])]
    assert least_separation_m([full[a - 1] for a in live], ends) < 1e-9
