"""Claims about shapes, references, frames and desired motions of a formation."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.formations.frame import Course, Offset, course_of, world_offset
from auv_control.formations.references import Weights, check_weights, is_look_ahead, reference_weights
from auv_control.formations.shapes import (
    NO_SLOT,
    SHAPES,
    graph_neighbours,
    least_distance_m,
    neighbours_within,
    predecessors,
    shape_slots,
)
from auv_control.formations.switching import Transition
from auv_control.formations.targets import Guide, desired_motion, guide_of_path
from auv_control.references import PathPoint
from auv_control.references.circle import Params as CircleParams
from auv_control.references.circle import Reference as Circle
from auv_core.geometry import added

MODERATE = settings(max_examples=60, deadline=None)
D_M = 10.0

counts = st.integers(1, 13)
coordinates = st.floats(-50.0, 50.0)
points = st.tuples(coordinates, coordinates, coordinates)
rates = st.floats(-0.5, 0.5)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("half_angle_deg", [30.0, 45.0, 90.0, 150.0])
def test_no_two_slots_are_closer_than_the_spacing(shape, half_angle_deg):
    for count in range(2, 14):
        slots = shape_slots(shape, count, D_M, math.radians(half_angle_deg))
        assert least_distance_m(slots) == pytest.approx(D_M)
        assert slots[0][0] == max(slot[0] for slot in slots) or half_angle_deg > 90.0


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("column", [None, 0, 1, 2, 3, 4, 5, 6]),
        ("line", [None, 0, 0, 1, 2, 3, 4, 5]),
        ("wedge", [None, 0, 0, 1, 2, 3, 4, 5]),
        ("double_platoon", [None, 0, 0, 1, 2, 3, 4, 5]),
        ("diamond", [None, 0, 0, 1, 3, 4, 4, 5]),
    ],
)
def test_each_slot_follows_the_one_before_it_in_its_line(shape, expected):
    assert list(predecessors(shape_slots(shape, 8, D_M)))[1:] == expected[1:]


@MODERATE
@given(st.sampled_from(SHAPES), counts, st.integers(0, 12))
def test_every_slot_leads_to_the_leading_one_along_the_same_graph(shape, count, place):
    slots, leading = shape_slots(shape, count, D_M), place % count
    followed = predecessors(slots, leading)
    assert followed[leading] == NO_SLOT
    assert graph_neighbours(followed) == graph_neighbours(predecessors(slots))
    for slot in range(count):
        steps = 0
        while slot != leading:
            slot, steps = followed[slot], steps + 1
            assert steps < count


@MODERATE
@given(st.sampled_from(SHAPES), counts)
def test_the_neighbours_of_the_graph_are_mutual_and_within_reach(shape, count):
    slots = shape_slots(shape, count, D_M)
    near, within = graph_neighbours(predecessors(slots)), neighbours_within(slots, 1.5 * D_M)
    for slot, others in enumerate(near):
        assert all(slot in near[other] for other in others)
        assert set(others) <= set(within[slot])


def test_a_narrow_wedge_and_an_unknown_shape_are_refused():
    with pytest.raises(ValueError, match=r"half_angle_rad: 0\.2 is not allowed"):
        shape_slots("wedge", 3, D_M, 0.2)
    with pytest.raises(ValueError, match="shape: 'heap' is not allowed; allowed: column, line"):
        shape_slots("heap", 3, D_M)


def test_a_line_of_three_on_a_circle_is_the_formation_of_chapter_3():
    slots = shape_slots("line", 3, D_M)
    for t_s in np.linspace(0.0, 600.0, 13).tolist():
        path = Circle(CircleParams(radius_m=20.0, rate_radps=0.01, depth_m=10.0)).at(t_s)
        offsets = [world_offset(Offset(slot), course_of(path)) for slot in slots]
        for offset, radius_m in zip(offsets, (20.0, 30.0, 10.0), strict=True):
            place = [a + b for a, b in zip(path.position, offset.position, strict=True)]
            thesis = [radius_m * math.sin(0.01 * t_s), radius_m * math.cos(0.01 * t_s), 10.0]
            assert place == pytest.approx(thesis, abs=1e-12)


@MODERATE
@given(points, points, points, rates, rates, st.floats(-3.0, 3.0))
def test_the_rates_of_a_world_offset_are_its_derivatives(place, speed, push, rate, change, chi):
    step_s = 1e-4

    def at(t_s):
        slot = Offset(
            tuple(p + v * t_s + 0.5 * a * t_s**2 for p, v, a in zip(place, speed, push, strict=True)),
            tuple(v + a * t_s for v, a in zip(speed, push, strict=True)),
            push,
        )
        return world_offset(
            slot, Course(chi + rate * t_s + 0.5 * change * t_s**2, rate + change * t_s, change)
        )

    before, now, after = (at(k * step_s) for k in (-1.0, 0.0, 1.0))
    for axis in range(3):
        assert (after[0][axis] - before[0][axis]) / (2 * step_s) == pytest.approx(now[1][axis], abs=1e-4)
        assert (after[1][axis] - before[1][axis]) / (2 * step_s) == pytest.approx(now[2][axis], abs=1e-4)


def test_a_path_that_stands_has_the_course_of_its_heading():
    assert course_of(PathPoint((0.0, 0.0, 0.0), (0.0, 0.0, 0.3), heading_rad=0.7)) == Course(0.7)
    assert course_of(PathPoint((0.0, 0.0, 0.0), (0.0, 2.0, 0.0))).chi_rad == pytest.approx(0.5 * math.pi)


shares = st.sampled_from(
    [
        {"leader": 1.0},
        {"predecessor": 1.0},
        {"neighbour": 1.0},
        {"leader": 0.5, "predecessor": 0.5},
        {"leader": 0.8, "predecessor": 0.2},
        {"leader": 0.5, "neighbour": 0.5},
        {"predecessor": 0.5, "neighbour": 0.5},
        {"leader": 1 / 3, "predecessor": 1 / 3, "neighbour": 1 / 3},
    ]
)


@MODERATE
@given(shares, st.sampled_from(SHAPES), counts)
def test_the_rows_sum_to_one_and_look_ahead_unless_neighbours_count(share, shape, count):
    weights = reference_weights(share, predecessors(shape_slots(shape, count, D_M)))
    assert weights.others.sum(axis=1) + weights.path == pytest.approx(np.ones(count))
    assert weights.path[0] == 1.0
    # The neighbours of slot 0 do not count for it: two vehicles look ahead in any case.
    assert is_look_ahead(weights) or ("neighbour" in share and count > 2)
    if "neighbour" in share and count > 2 and shape == "column":
        assert not is_look_ahead(weights)


@pytest.mark.parametrize(
    ("share", "message"),
    [
        ({"leader": 0.5}, "references: the shares .* are not allowed; allowed: at least 0 each, 1 in sum"),
        ({"leader": 1.5, "predecessor": -0.5}, "references: the shares .* are not allowed"),
        ({"friend": 1.0}, "references: 'friend' is not allowed; allowed: leader, predecessor, neighbour"),
    ],
)
def test_shares_that_are_no_reference_type_are_refused(share, message):
    with pytest.raises(ValueError, match=message):
        reference_weights(share, (-1, 0, 1))


def test_a_slot_without_a_connection_to_the_path_is_refused():
    circle = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    with pytest.raises(ValueError, match=r"weights: slots \[1, 2\] without a connection to the path"):
        check_weights(Weights(circle, np.array([1.0, 0.0, 0.0])))
    with pytest.raises(ValueError, match="weights: a row 2 that sums to 0 is not allowed"):
        check_weights(Weights(np.zeros((3, 3)), np.array([1.0, 1.0, 0.0])))


@MODERATE
@given(shares, st.sampled_from(SHAPES), st.integers(2, 8), st.integers(0, 7), rates, points)
def test_a_formation_in_place_is_where_every_reference_type_wants_it(
    share, shape, count, place, rate, position
):
    slots = shape_slots(shape, count, D_M)
    weights = reference_weights(share, predecessors(slots, place % count))
    path = PathPoint(position, (0.4, 0.3, 0.1), (-0.3 * rate, 0.4 * rate, 0.0))
    offsets = [world_offset(Offset(slot), course_of(path)) for slot in slots]
    moving = [Offset(*(added(x, w) for x, w in zip(path[:3], offset, strict=True))) for offset in offsets]
    for slot in range(count):
        guides = [guide_of_path(weights.path[slot], path)]
        guides += [Guide(weights.others[slot, j], moving[j], offsets[j]) for j in range(count)]
        wanted = desired_motion(offsets[slot], guides, uses_accelerations=True)
        for found, expected in zip(wanted, moving[slot], strict=True):
            assert found == pytest.approx(expected, abs=1e-9)
        assert desired_motion(offsets[slot], guides, uses_accelerations=False).acceleration == (0.0, 0.0, 0.0)


@MODERATE
@given(points, points, st.floats(1.0, 60.0), st.floats(0.01, 0.99))
def test_a_transition_goes_from_one_offset_to_the_other(before, after, duration_s, share):
    way = Transition(before, after, 5.0, duration_s)
    assert way.at(5.0).position == pytest.approx(before, abs=1e-9)
    assert way.at(5.0 + 1.001 * duration_s) == Offset(after)
    t_s, step_s = 5.0 + share * duration_s, 1e-4 * duration_s
    early, now, late = (way.at(t_s + k * step_s) for k in (-1, 0, 1))
    for axis in range(3):
        rate = (late[0][axis] - early[0][axis]) / (2 * step_s)
        assert rate == pytest.approx(now[1][axis], abs=1e-4 * max(1.0, math.dist(before, after)) / duration_s)


def test_a_transition_can_be_turned_to_another_offset_on_the_way():
    way = Transition((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), 0.0, 10.0)
    other = way.turned_to((0.0, 4.0, 0.0), 5.0, 10.0)
    assert other.at(5.0).position == way.at(5.0).position == pytest.approx((2.0, 0.0, 0.0))
    assert other.at(15.0).position == (0.0, 4.0, 0.0)
