"""Claims about obstacle tracks: what becomes one, where it is, and what a neighbour's contacts do."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from auv_core.messages import VehicleState
from auv_flocking.neighbours.navigation_offset import OwnFix
from auv_flocking.neighbours.rivals import NO_RIVALS
from auv_flocking.neighbours.sonar_contact import contact_of
from auv_flocking.neighbours.table import NeighbourConfig, NeighbourTable
from auv_flocking.report import Report
from auv_flocking.trackers.kalman import Params, Tracker

PARAMS = Params()
PING_S = 0.5
MODERATE = settings(max_examples=30, deadline=None)
RELATIVE = st.tuples(st.floats(1.0, 8.0), st.floats(-8.0, 8.0), st.floats(-5.0, 5.0))
SPEEDS = st.tuples(*[st.floats(-0.2, 0.2)] * 3)


class Observer:
    """A vehicle at rest at the origin with a sonar, one neighbour table and one tracker."""

    def __init__(self, params=PARAMS, known=()):
        self.table = NeighbourTable(NeighbourConfig(timeout_s=300.0))
        self.tracker = Tracker(params, known)
        self.t_s = 0.0

    def hear(self, address, position, velocity=(0.0, 0.0, 0.0)):
        zero = (0.0, 0.0, 0.0)
        self.table.receive(Report(address, self.t_s, position, velocity, zero, zero))

    def ping(self, *places, noise=None):
        """See things at these places (m; NED), with the noise of a generator if there is one."""
        nav = VehicleState(0, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)
        contacts = [contact_of(place) for place in places]
        if noise is not None:
            contacts = [
                c._replace(
                    range_m=c.range_m + noise.normal(0.0, 0.1),
                    bearing_rad=c.bearing_rad + noise.normal(0.0, 0.0174533),
                    elevation_rad=c.elevation_rad + noise.normal(0.0, 0.0174533),
                )
                for c in contacts
            ]
        left = self.table.observe(self.t_s, nav, contacts, self.tracker.rivals(self.t_s))
        self.tracker.observe(self.t_s, left)
        self.t_s += PING_S

    @property
    def found(self):
        return self.tracker.obstacles(self.t_s)


@MODERATE
@given(RELATIVE, st.integers(1, 6))
def test_an_obstacle_is_confirmed_by_as_many_contacts_as_asked_for_and_not_before(place, wanted):
    own = Observer(replace(PARAMS, confirm_contacts=wanted, confirm_s=10.0))
    for count in range(1, wanted + 1):
        own.ping(place)
        assert len(own.found) == (count == wanted)


def test_contacts_that_come_too_rarely_confirm_nothing():
    own = Observer()
    for _ in range(20):
        own.ping((4.0, 0.0, 0.0))
        own.t_s += PARAMS.confirm_s
        assert own.found == ()


@MODERATE
@given(RELATIVE, SPEEDS, st.integers(0, 2**32 - 1))
@example((1.0, 0.0, 0.0), (0.0, 0.0, 0.0625), 1_115_651_456)
def test_a_track_is_where_the_obstacle_is_and_as_fast(place, velocity, seed):
    own, noise = Observer(), np.random.default_rng(seed)
    for _ in range(40):
        now = np.array(place) + own.t_s * np.array(velocity)
        own.ping(tuple(now.tolist()), noise=noise)
    track, *doubles = own.found
    assert len(doubles) <= 1, "a contact outside the gate may begin a second track, for a few pings"
    there = np.array(place) + own.t_s * np.array(velocity)
    assert np.linalg.norm(track.position - there) < 5.0 * track.sigma_m
    assert np.linalg.norm(np.subtract(track.velocity, velocity)) < 0.15
    assert 0.0 < track.sigma_m < 0.3


@MODERATE
@given(RELATIVE, st.floats(0.0, 19.0))
def test_an_obstacle_out_of_sight_is_remembered_with_growing_uncertainty_and_then_forgotten(place, later_s):
    own = Observer()
    for _ in range(5):
        own.ping(place)
    own.t_s -= PING_S
    (fresh,), (old,) = own.found, own.tracker.obstacles(own.t_s + later_s)
    assert old.sigma_m >= fresh.sigma_m
    assert old.age_s == pytest.approx(later_s)
    assert own.tracker.obstacles(own.t_s + PARAMS.forget_s + 1e-6) == ()


def test_a_neighbour_that_is_heard_is_no_obstacle():
    own = Observer()
    own.hear(2, (4.0, 0.0, 0.0))
    for _ in range(20):
        own.ping((4.0, 0.0, 0.0))
    assert own.found == ()
    assert own.table.contacts_used == 20


def test_a_vehicle_is_an_obstacle_until_it_is_heard():
    own = Observer()
    for _ in range(10):
        own.ping((4.0, 0.0, 0.0))
    assert len(own.found) == 1
    own.hear(2, (4.0, 0.0, 0.0))
    for _ in range(5):
        own.ping((4.0, 0.0, 0.0))
    assert own.found == ()
    assert own.table.contacts_used > 0


@MODERATE
@given(st.floats(1.0, 3.0))
def test_an_obstacle_beside_a_neighbour_stays_an_obstacle_and_does_not_pull_it(apart_m):
    own, noise = Observer(), np.random.default_rng(1)
    neighbour, rock = (4.0, 0.0, 0.0), (4.0, apart_m, 0.0)
    for ping in range(60):
        if ping % 4 == 0:
            own.hear(2, neighbour)
        places = [place for place in (neighbour, rock) if noise.random() < 0.9]
        own.ping(*places, noise=noise)
    (track,) = own.found
    assert math.dist(track.position, rock) < 0.4
    (estimate,) = own.table.estimates(own.t_s)
    assert math.dist(estimate.position, neighbour) < 0.3


def test_a_neighbour_that_may_be_anywhere_claims_no_contact_of_an_obstacle():
    own = Observer()
    own.hear(2, (6.0, 3.0, 0.0), velocity=(0.1, 0.0, 0.0))
    own.t_s = 60.0
    (before,) = own.table.estimates(own.t_s)
    assert math.sqrt(before.covariance[0, 0]) > 3.0, "it was not heard for a minute"
    for _ in range(5):
        own.ping((8.0, 0.0, 0.0))
    assert len(own.found) == 1
    assert own.table.contacts_used == 0


def test_without_rivals_the_neighbour_table_does_what_it_always_did():
    ours, plain = Observer(), NeighbourTable(NeighbourConfig(timeout_s=300.0))
    ours.hear(2, (6.0, 3.0, 0.0))
    zero = (0.0, 0.0, 0.0)
    plain.receive(Report(2, 0.0, (6.0, 3.0, 0.0), zero, zero, zero))
    nav = VehicleState(0, zero, (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)
    contacts = [contact_of((6.1, 3.1, 0.0)), contact_of((1.0, 1.0, 0.0))]
    for t_s in (0.5, 60.0):
        ours.table.observe(t_s, nav, contacts, NO_RIVALS)
        plain.observe(t_s, nav, contacts)
    assert ours.table.contacts_used == plain.contacts_used > 0
    assert (ours.table.estimates(61.0).rows == plain.estimates(61.0).rows).all()


@pytest.mark.parametrize(("off_m", "is_explained"), [(0.0, True), (0.2, True), (2.0, False)])
def test_a_known_obstacle_explains_contacts_only_where_the_vehicle_expects_it(off_m, is_explained):
    own = Observer(known=((5.0, 0.0, 0.0),))
    for _ in range(5):
        own.ping((5.0, off_m, 0.0))
    assert (own.found == ()) is is_explained


def test_of_two_tracks_of_one_obstacle_the_younger_is_dropped():
    own, rock = Observer(), (4.0, 0.0, 0.0)
    for _ in range(6):
        own.ping(rock, (4.0, 1.0, 0.0))
    assert len(own.found) == 2
    for step in range(10):
        own.ping((4.0, 0.0, 0.0), (4.0, 1.0 - 0.1 * step, 0.0))
    for _ in range(10):
        own.ping(rock)
    assert [track.number for track in own.found] == [1]


def test_a_fix_moves_every_track():
    own = Observer()
    for _ in range(5):
        own.ping((4.0, 0.0, 0.0))
    (before,) = own.found
    own.tracker.follow(OwnFix(own.t_s, (1.5, -0.5), 4.0, 0.1))
    (after,) = own.found
    assert np.subtract(after.position, before.position) == pytest.approx((1.5, -0.5, 0.0))
