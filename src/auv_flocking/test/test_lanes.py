"""Claims about a fleet of torpedoes in lanes: it forms, stays apart, and holds without packets."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lane_fleet import Setting, autopilots, coordination_error_m, distances_m, fly, formed_s, random_starts

from auv_control.guidance.paths import lawnmower
from auv_core import compiled
from auv_core.params import ConfigError, Section, load
from auv_flocking.coordination import age_matched, tanh
from auv_flocking.fleets import Mission
from auv_flocking.fleets.lanes import Fleet, Params
from auv_flocking.flocking import Member
from auv_flocking.lanes import modes
from auv_flocking.lanes.status import Mode

SHORT = Setting(seed=1001, count=3, duration_s=330.0)


@pytest.fixture(autouse=True)
def _compiled(monkeypatch):
    monkeypatch.setattr(compiled, "_is_on", True)


def alive_after(flown, since_s):
    """Return which periods are after a time (s)."""
    return flown.times_s >= since_s


def test_starts_are_apart_and_follow_the_seed():
    starts = random_starts(3001, 5)
    assert starts == random_starts(3001, 5)
    apart = [math.dist(a, b) for i, a in enumerate(starts.places) for b in starts.places[:i]]
    assert min(apart) >= 60.0
    assert max(apart) <= 200.0


def test_a_fleet_forms_and_keeps_its_distances():
    flown = fly(SHORT)
    late = alive_after(flown, formed_s(flown) + 40.0)
    assert formed_s(flown) < 250.0
    assert coordination_error_m(flown)[late].max() < 1.0
    assert abs(flown.cross_tracks_m[late]).max() < 0.7
    assert distances_m(flown).min() > 5.0
    assert np.ptp(flown.positions[-1, :, 2]) < 0.5, "all at the depth of the formation"


def test_a_flight_repeats_to_the_last_bit():
    short = replace(SHORT, duration_s=40.0)
    np.testing.assert_array_equal(fly(short).positions, fly(short).positions)


def test_without_packets_vehicles_stay_in_their_layers_and_loiter():
    """Nothing is heard from the start on: TRANSIT, INLANE, LEAVE after 300 s, LOITER 120 s later."""
    flown = fly(replace(SHORT, silent_s=(0.0, math.inf), duration_s=450.0))
    assert set(flown.modes.flat) == {Mode.TRANSIT, Mode.INLANE, Mode.LEAVE, Mode.LOITER}
    assert (flown.modes[-1] == Mode.LOITER).all()
    assert distances_m(flown).min() > 5.0
    depths_m = np.sort(flown.positions[-1, :, 2])
    np.testing.assert_allclose(depths_m, [24.0, 36.0, 42.0], atol=0.5)


def test_one_vehicle_alone_forms_and_never_leaves():
    flown = fly(replace(SHORT, count=1, current_mps=0.0, duration_s=200.0))
    assert flown.modes[-1, 0] == Mode.FORM


def test_at_the_end_of_an_open_path_the_fleet_loiters_in_its_layers():
    survey = Section("lawnmower", lawnmower.Params(legs=1, leg_m=250.0))
    params = Params(path=survey, loiter_north_m=300.0, modes=modes.Params(settle_s=20.0))
    flown = fly(replace(SHORT, current_mps=0.0, params=params, duration_s=400.0))
    assert (flown.modes == Mode.FORM).all(axis=1).any()
    assert (flown.modes[-1] == Mode.LOITER).all(), "packets do not bring it back"
    assert distances_m(flown).min() > 5.0
    np.testing.assert_allclose(np.sort(flown.positions[-1, :, 2]), [24.0, 36.0, 42.0], atol=0.5)


def test_the_cycle_of_the_channel_must_be_known():
    with pytest.raises(ValueError, match=r"cycle_s: missing; allowed: a number"):
        Fleet(Params(), Member(False, 1, 3), autopilots(), 0.2, Mission())
    with pytest.raises(ValueError, match=r"cycle_s: 7.0 is not allowed; allowed: 6, the cycle"):
        Fleet(Params(cycle_s=7.0), Member(False, 1, 3), autopilots(), 0.2, Mission(cycle_s=6.0))


def test_layers_that_meet_a_slot_are_refused():
    with pytest.raises(ValueError, match=r"depth_m: 5.0 is not allowed"):
        Fleet(Params(depth_m=5.0), Member(False, 1, 3), autopilots(), 0.2, Mission(cycle_s=6.0))


def test_unknown_laws_are_refused_in_one_line():
    with pytest.raises(
        ConfigError, match=r"lane.coordination.kind: 'pid' is not allowed; allowed: age_matched"
    ):
        load(Params, {"coordination": {"kind": "pid"}}, "lane")


FIVE = Setting(duration_s=900.0)


def assert_formed(flown, *, error_m, formed_within_s):
    late = alive_after(flown, 700.0)
    assert distances_m(flown).min() > 5.0
    assert formed_s(flown) <= formed_within_s
    assert np.quantile(coordination_error_m(flown)[late], 0.95) <= error_m
    cross_tracks_m = flown.cross_tracks_m[late]
    assert math.sqrt((cross_tracks_m**2).mean()) <= 0.1
    assert abs(cross_tracks_m).max() <= 0.7


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3001, 3004))
@pytest.mark.parametrize(("slot_s", "formed_within_s"), [(2.0, 620.0), (8.0, 700.0)])
def test_five_vehicles_abreast(seed, slot_s, formed_within_s):
    flown = fly(replace(FIVE, seed=seed, slot_s=slot_s))
    assert_formed(flown, error_m=1.0, formed_within_s=formed_within_s)
    minutes = (flown.times_s[-1] - 700.0) / 60.0
    assert sum(1 for t_s in flown.sent_s if t_s >= 700.0) / minutes <= 6.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "count", "spacing_m"), [("wedge", 5, 15.0), ("column", 5, 20.0), ("diamond", 4, 15.0)]
)
def test_other_shapes(shape, count, spacing_m):
    flown = fly(replace(FIVE, seed=3002, shape=shape, count=count, spacing_m=spacing_m))
    assert_formed(flown, error_m=1.0, formed_within_s=620.0)


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "spacing_m"), [("line", 15.0), ("column", 20.0)])
def test_a_lost_vehicle_rises_astern_of_the_others(shape, spacing_m):
    flown = fly(replace(FIVE, seed=3001, shape=shape, spacing_m=spacing_m, lost=((1, 650.0),)))
    assert distances_m(flown).min() > 5.0
    assert flown.positions[-1, 0, 2] < 5.0


@pytest.mark.slow
def test_five_minutes_of_silence_do_not_drive_a_formation_apart():
    patient = Params(modes=modes.Params(lost_s=600.0))
    flown = fly(replace(FIVE, seed=3002, silent_s=(600.0, 900.0), params=patient))
    assert (flown.modes[-1] == Mode.FORM).all()
    assert distances_m(flown).min() > 5.0
    assert np.quantile(coordination_error_m(flown)[alive_after(flown, 800.0)], 0.95) <= 0.6


@pytest.mark.slow
def test_a_weak_vehicle_is_waited_for():
    flown = fly(replace(FIVE, seed=1000, current_mps=0.0, weak=(1,), duration_s=1200.0))
    error_m = coordination_error_m(flown)[alive_after(flown, 700.0)]
    assert math.sqrt((error_m**2).mean()) < 4.0
    assert np.quantile(error_m, 0.95) < 9.2


@pytest.mark.slow
def test_the_other_laws_are_worse_on_a_bad_channel():
    bad = replace(FIVE, seed=1000, slot_s=8.0, loss_prob=0.6, duration_s=1200.0)
    laws = (
        Params().coordination,
        Section("tanh", tanh.Params()),
        Section("age_matched", age_matched.Params()),
    )
    errors_m = []
    for law in laws:
        flown = fly(replace(bad, params=Params(coordination=law)))
        errors_m.append(np.quantile(coordination_error_m(flown)[alive_after(flown, 700.0)], 0.95))
    assert errors_m[0] < 0.5
    assert errors_m[0] < errors_m[1] < errors_m[2]
