"""Claims about the detection of other hulls by sonar."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.geometry import body_to_ned, distance, quaternion_from_heading
from auv_core.messages import VehicleState
from auv_sim.acoustics.sonar import active, none

PERIOD_S = 0.1
LEVEL = (1.0, 0.0, 0.0, 0.0)
SURE = active.Params(range_sd_m=0.0, angle_sd_rad=0.0, detection_prob=1.0)


def at(position, attitude=LEVEL, tick=0):
    return VehicleState(tick, tuple(position), attitude, (0.0,) * 6)


def seen(params, states, *, seed=1, address=1, tick=0, period_s=PERIOD_S):
    return active.Sonar(params, seed).contacts(address, tick, period_s, states)


def place(contact, attitude):
    """Return where a contact says that the hull is, relative to the observer (m; NED)."""
    level_m = contact.range_m * math.cos(contact.elevation_rad)
    body = (
        level_m * math.cos(contact.bearing_rad),
        level_m * math.sin(contact.bearing_rad),
        -contact.range_m * math.sin(contact.elevation_rad),
    )
    return body_to_ned(attitude, body)


unit_quaternions = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: tuple(c / math.hypot(*q) for c in q))
)
points = st.tuples(*[st.floats(-20.0, 20.0)] * 3)


@settings(max_examples=100, deadline=None)
@given(points, unit_quaternions, st.lists(points, min_size=1, max_size=4))
def test_without_noise_every_hull_in_reach_is_seen_where_it_is(own, attitude, others):
    contacts = seen(SURE, [at(own, attitude), *map(at, others)])
    places = [place(contact, attitude) for contact in contacts]
    near = sorted((p for p in others if distance(own, p) <= 10.0), key=lambda p: distance(own, p))
    assert len(places) == len(near)
    for point in near:
        wanted = tuple(a - b for a, b in zip(point, own, strict=True))
        assert min(distance(wanted, given) for given in places) < 1e-6


@pytest.mark.parametrize(
    ("other", "bearing_rad", "elevation_rad"),
    [
        ((0.0, 5.0, 0.0), 0.0, 0.0),
        ((-5.0, 0.0, 0.0), 0.5 * math.pi, 0.0),
        ((0.0, 0.0, -5.0), None, 0.5 * math.pi),
        ((0.0, 4.0, 4.0), 0.0, -0.25 * math.pi),
    ],
    ids=["ahead", "starboard", "above", "ahead and below"],
)
def test_signs_of_a_vehicle_that_heads_east(other, bearing_rad, elevation_rad):
    (contact,) = seen(SURE, [at((0.0,) * 3, quaternion_from_heading(0.5 * math.pi)), at(other)])
    assert contact.range_m == pytest.approx(math.hypot(*other))
    assert contact.elevation_rad == pytest.approx(elevation_rad, abs=1e-9)
    assert bearing_rad is None or contact.bearing_rad == pytest.approx(bearing_rad, abs=1e-9)


def test_noise_and_detection_have_the_numbers_asked_for():
    sonar = active.Sonar(active.Params(), 7)
    states = [at((0.0,) * 3), at((3.0, 4.0, 0.0))]
    contacts = [c for tick in range(0, 40000, 5) for c in sonar.contacts(1, tick, PERIOD_S, states)]
    errors = np.array(
        [(c.range_m - 5.0, c.bearing_rad - math.atan2(4, 3), c.elevation_rad) for c in contacts]
    )
    share, n = len(contacts) / 8000, len(contacts)
    assert share == pytest.approx(0.9, abs=4.0 * math.sqrt(0.09 / 8000))
    sd = np.array([0.1, math.radians(1.0), math.radians(1.0)])
    np.testing.assert_allclose(errors.std(axis=0) / sd, 1.0, atol=4.0 / math.sqrt(2 * n))
    assert (np.abs(errors.mean(axis=0)) / sd < 4.0 / math.sqrt(n)).all()
    assert np.abs(np.corrcoef(errors.T) - np.eye(3)).max() < 4.0 / math.sqrt(n)
    assert abs(np.corrcoef(errors[:-1, 0], errors[1:, 0])[0, 1]) < 4.0 / math.sqrt(n)


@pytest.mark.parametrize(
    ("rate_hz", "period_s", "pings_per_s"),
    [
        (2.0, 0.1, 2.0),
        (3.0, 0.1, 3.0),
        (10.0, 0.1, 10.0),
        (50.0, 0.1, 10.0),
        (0.7, 0.1, 0.7),
        (2.0, 0.3, 2.0),
    ],
)
def test_pings_come_at_the_rate_and_once_per_tick_at_most(rate_hz, period_s, pings_per_s):
    sonar = active.Sonar(active.Params(rate_hz=rate_hz, detection_prob=1.0), 1)
    states = [at((0.0,) * 3), at((5.0, 0.0, 0.0))]
    ticks = [tick for tick in range(3000) if sonar.contacts(1, tick, period_s, states)]
    assert len(ticks) == pytest.approx(pings_per_s * 3000 * period_s, abs=1)
    assert ticks[0] == 0
    assert np.ptp(np.diff(ticks)) <= 1


def test_pings_on_the_tick_keep_their_tick_for_days():
    sonar = active.Sonar(active.Params(detection_prob=1.0), 1)
    states = [at((0.0,) * 3), at((5.0, 0.0, 0.0))]
    for start in (0, 10**6, 10**7):
        assert [bool(sonar.contacts(1, start + k, 0.1, states)) for k in range(10)] == [
            True,
            *[False] * 4,
        ] * 2


def test_luck_belongs_to_seed_pair_and_tick():
    two = [at((0.0,) * 3), at((5.0, 0.0, 0.0))]
    three = [*two, at((0.0, 9.0, 0.0))]
    (alone,) = seen(active.Params(), two, tick=5)
    assert alone in seen(active.Params(), three, tick=5), "another vehicle changes nothing"
    sonar = active.Sonar(active.Params(), 1)
    for tick in (500, 100, 5):
        again = sonar.contacts(1, tick, PERIOD_S, two)
    assert again == (alone,), "nor does what was asked before"
    assert {seen(active.Params(), two, tick=5, seed=s) for s in range(2, 6)}.isdisjoint({(alone,)})


def test_the_order_of_contacts_has_no_identity():
    sonar = active.Sonar(active.Params(detection_prob=1.0), 1)
    near_second = [at((0.0,) * 3), at((2.0, 0.0, 0.0)), at((0.0, 8.0, 0.0))]
    near_third = [near_second[0], near_second[2], near_second[1]]
    for states in (near_second, near_third):
        ranges = [c.range_m for c in sonar.contacts(1, 0, PERIOD_S, states)]
        assert ranges == sorted(ranges)
        assert ranges[0] == pytest.approx(2.0, abs=0.6)


def test_field_of_view():
    ahead_only = active.Params(detection_prob=1.0, horizontal_view_rad=math.pi / 2, vertical_view_rad=0.2)
    others = {
        "ahead": (5, 0, 0),
        "inside": (5, 4.9, 0),
        "beside": (0, 5, 0),
        "astern": (-5, 0, 0),
        "up": (5, 0, -2),
    }
    found = {name: bool(seen(ahead_only, [at((0.0,) * 3), at(p)])) for name, p in others.items()}
    assert found == {"ahead": True, "inside": True, "beside": False, "astern": False, "up": False}


@settings(max_examples=60, deadline=None)
@given(points, st.integers(0, 2**31 - 1), st.floats(0.0, 3.0), st.floats(0.0, 1.0))
def test_numbers_stay_in_their_ranges_whatever_the_noise(other, seed, range_sd_m, angle_sd_rad):
    params = active.Params(
        max_range_m=50.0, range_sd_m=range_sd_m, angle_sd_rad=angle_sd_rad, detection_prob=1.0
    )
    (contact,) = seen(params, [at((0.0,) * 3), at(other)], seed=seed)
    assert contact.range_m >= 0.0
    assert abs(contact.bearing_rad) <= math.pi
    assert abs(contact.elevation_rad) <= 0.5 * math.pi


def test_a_state_without_numbers_is_not_seen():
    assert seen(SURE, [at((0.0,) * 3), at((math.nan,) * 3)]) == ()


def test_none_sees_nothing():
    states = [at((0.0,) * 3), at((1.0, 0.0, 0.0))]
    assert none.Sonar(none.Params(), 1).contacts(1, 0, PERIOD_S, states) == ()
