"""Claims about the flocking law for a modem: no faster than its information, never closer than it may."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.references import PathPoint
from auv_flocking.flocking import NOTHING_HEARD, FlockVelocity, Member, View, potential
from auv_flocking.flocking._correction import outlook
from auv_flocking.flocking.communication_aware import Flocking, Params
from auv_flocking.neighbours.estimates import Estimates, NeighbourEstimate
from auv_flocking.separation import mathematical
from auv_flocking.trackers import SensedObstacle

MODERATE = settings(max_examples=60, deadline=None)
SEPARATION = mathematical.Separation(mathematical.Params())
PERIOD_S = 0.1
W = (0.1, 0.0, 0.0)
PATH = PathPoint((0.0, 1.0, 10.0), (0.1, 0.0, 0.0))
ORIGIN = (0.0, 0.0, 0.0)
DISTANT = 1e9

POINTS = st.tuples(*[st.floats(-8.0, 8.0)] * 3)
SPEEDS = st.tuples(*[st.floats(-0.3, 0.3)] * 3)
AGES = st.floats(0.0, 60.0)


def _estimate(position, *, age_s=0.0, velocity=W, sigma_m=0.0, sonar_age_s=math.inf, heard=None, address=2):
    velocity_ned, stamp_s = heard or (W, -1.0)
    covariance = np.diag([sigma_m**2] * 3 + [1e-4] * 3)
    return NeighbourEstimate(
        address,
        position,
        velocity,
        covariance,
        age_s,
        ORIGIN,
        velocity_ned,
        stamp_s,
        sonar_age_s,
        time_s=-age_s,
    )


def _view(own, estimates, *, centre=None, obstacles=(), flock=W):
    positions = tuple(estimate.position for estimate in estimates)
    everybody = np.mean([own, *positions], axis=0)
    centre = tuple(everybody.tolist()) if centre is None else centre
    return View(own, centre, flock, positions, obstacles, PATH, tuple(estimates))


def _law(estimates=(), *, is_leader=False, **numbers):
    law = Flocking(Params(**numbers), SEPARATION, Member(is_leader))
    law.hear(tuple(estimates), PERIOD_S)
    return law


def _correction(law, view):
    return np.subtract(law.velocity(view), view.flock_velocity)


ESTIMATES = st.lists(
    st.builds(
        lambda position, age_s, velocity, sigma_m: _estimate(
            position, age_s=age_s, velocity=velocity, sigma_m=sigma_m
        ),
        POINTS,
        AGES,
        SPEEDS,
        st.floats(0.0, 2.0),
    ),
    min_size=1,
    max_size=4,
).map(lambda found: [estimate._replace(address=2 + k) for k, estimate in enumerate(found)])


@MODERATE
@given(own=POINTS, others=st.lists(POINTS, min_size=1, max_size=4))
def test_with_fresh_information_it_is_the_potential_law_in_the_flocks_frame(own, others):
    estimates = [_estimate(other, address=2 + k) for k, other in enumerate(others)]
    law = _law(estimates, barrier=False, correction_limit_mps=DISTANT, reach_m=DISTANT)
    thesis = potential.Flocking(
        potential.Params(followers="blind", feedforward="flock"), SEPARATION, Member()
    )
    view = _view(own, estimates)
    np.testing.assert_allclose(law.velocity(view), thesis.velocity(view), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("age_s", [1.0, 4.0, 20.0])
def test_gain_times_age_is_the_lag_budget(age_s):
    far = [_estimate((10.0, 0.0, 0.0), age_s=age_s)]
    law = _law(far, lag_budget_rad=0.3, age_memory_s=1e-9, correction_limit_mps=DISTANT, reach_m=DISTANT)
    assert law.age_s == pytest.approx(age_s)
    asked = _correction(law, _view(ORIGIN, far, centre=(4.0, 0.0, 0.0)))
    np.testing.assert_allclose(asked, [4.0 * 0.3 / age_s, 0.0, 0.0], rtol=1e-9)


def test_age_is_measured_and_remembered():
    law = Flocking(Params(age_memory_s=40.0), SEPARATION, Member(fleet_size=2))
    for _ in range(100):
        law.hear((), PERIOD_S)
    assert law.age_s == pytest.approx(10.0)  # nothing heard for as long as it runs
    law.hear((_estimate(ORIGIN, age_s=0.5),), PERIOD_S)
    assert 9.9 < law.age_s <= 10.0  # one packet after ten seconds does not make a fast link
    for _ in range(4000):
        law.hear((_estimate(ORIGIN, age_s=2.0),), PERIOD_S)
    assert law.age_s == pytest.approx(2.0, abs=1e-3)
    law.hear((_estimate(ORIGIN, age_s=30.0),), PERIOD_S)
    assert law.age_s == 30.0  # a silence counts at once


def test_one_vehicle_alone_knows_all_there_is_with_the_lag_of_its_hull():
    law = Flocking(Params(), SEPARATION, Member(is_leader=True))
    for _ in range(600):
        law.hear((), PERIOD_S)
    assert (law.age_s, law.bandwidth_ratio) == (1.0, 0.3)


@MODERATE
@given(own=POINTS, estimates=ESTIMATES)
def test_correction_is_bounded(own, estimates):
    law = _law(estimates)
    assert np.linalg.norm(_correction(law, _view(own, estimates))) <= Params().correction_limit_mps + 1e-9


@MODERATE
@given(own=POINTS, estimate=ESTIMATES.map(lambda found: found[0]), centre=POINTS)
def test_barrier_bounds_the_approach_to_a_neighbour(own, estimate, centre):
    p = Params()
    distance_m = math.dist(own, estimate.position)
    if distance_m < 1e-6:
        return
    normal = np.subtract(own, estimate.position) / distance_m
    sigma_m = math.sqrt(
        estimate.covariance[0, 0] + (p.closing_ratio * estimate.age_s * math.dist(estimate.velocity, W)) ** 2
    )
    left_m = distance_m - p.barrier_distance_m - min(p.barrier_sigmas * sigma_m, p.widening_limit_m)
    limit_mps = min(p.correction_limit_mps, p.reach_m / max(estimate.age_s, 1e-3))
    rate_ps = 0.5 * min(p.barrier_rate_ps, 1.0 / max(estimate.age_s, 1e-3))
    apart_mps = normal @ _correction(_law([estimate]), _view(own, [estimate], centre=centre))
    bound_mps = min(-rate_ps * left_m, limit_mps)
    # Inside the distance both move apart; what they do across may take up to 0.3 of that.
    assert apart_mps >= (bound_mps if bound_mps <= 0.0 else bound_mps / math.sqrt(2.0)) - 1e-9


@MODERATE
@given(own=POINTS, other=POINTS, age_s=AGES, sigma_m=st.floats(0.0, 2.0))
def test_two_that_know_the_same_of_each_other_do_the_opposite(own, other, age_s, sigma_m):
    if math.dist(own, other) < 1e-6:
        return
    there = [_estimate(other, age_s=age_s, sigma_m=sigma_m)]
    back = [_estimate(own, age_s=age_s, sigma_m=sigma_m, address=1)]
    mine = _correction(_law(there), _view(own, there))
    others = _correction(_law(back), _view(other, back))
    np.testing.assert_allclose(mine, -others, atol=1e-9)


def test_what_is_uncertain_is_kept_at_a_greater_distance():
    near = (2.2, 0.0, 0.0)
    still = {"barrier": False, "cohesion_gain_ps": 0.0}
    sure, unsure = ([_estimate(near, sigma_m=sigma_m)] for sigma_m in (0.0, 0.5))
    assert not _correction(_law(sure, **still), _view(ORIGIN, sure)).any()
    assert _correction(_law(unsure, **still), _view(ORIGIN, unsure))[0] < 0.0
    assert not _correction(_law(unsure, **still, spacing_sigmas=0.0), _view(ORIGIN, unsure)).any()


def test_what_moves_in_the_flock_grows_uncertain_with_its_age():
    near, still = (2.2, 0.0, 0.0), {"barrier": False, "cohesion_gain_ps": 0.0}
    with_flock, across = ([_estimate(near, age_s=10.0, velocity=v)] for v in (W, (0.0, 0.1, 0.0)))
    assert not _correction(_law(with_flock, **still), _view(ORIGIN, with_flock)).any()
    assert _correction(_law(across, **still), _view(ORIGIN, across))[0] < 0.0


@pytest.mark.parametrize(("contact_s", "counts_as_s"), [(0.5, 1.0), (3.0, 3.0)])
def test_sonar_makes_a_neighbour_as_fresh_as_its_contact_and_no_fresher_than_the_hull(contact_s, counts_as_s):
    numbers: dict[str, Any] = {
        "barrier": False,
        "cohesion_gain_ps": 0.0,
        "correction_limit_mps": DISTANT,
        "reach_m": DISTANT,
    }
    heard, seen = (
        [_estimate((1.5, 0.0, 0.0), age_s=20.0, sonar_age_s=age_s)] for age_s in (math.inf, contact_s)
    )
    slow = _correction(_law(heard, **numbers), _view(ORIGIN, heard))
    fast = _correction(_law(seen, **numbers), _view(ORIGIN, seen))
    np.testing.assert_allclose(fast * counts_as_s, slow * 20.0, rtol=1e-9)


def test_over_a_cycle_of_packets_the_gain_changes_by_a_factor_of_two_and_not_by_that_of_the_age():
    numbers: dict[str, Any] = {
        "barrier": False,
        "cohesion_gain_ps": 0.0,
        "correction_limit_mps": DISTANT,
        "reach_m": DISTANT,
    }
    law = Flocking(Params(**numbers), SEPARATION, Member())
    pushes = []
    for tick in range(4000):
        estimates = [_estimate((1.5, 0.0, 0.0), age_s=0.1 * (1 + tick % 20))]
        law.hear(estimates, 0.1)
        pushes.append(law.velocity(_view(ORIGIN, estimates))[0] - W[0])
    settled = np.abs(pushes[-400:])
    assert settled.max() < 2.1 * settled.min()


def test_followers_pass_on_the_newest_flock_velocity():
    estimates = [
        _estimate(ORIGIN, heard=((0.1, 0.2, 0.0), 4.0)),
        _estimate(ORIGIN, heard=((0.3, 0.0, 0.0), 7.0), address=3),
        _estimate(ORIGIN, heard=(ORIGIN, -math.inf), address=4),
    ]
    law = _law(estimates)
    heard = law.flock_velocity(9.0, PATH, ORIGIN, NOTHING_HEARD, estimates)
    assert heard == FlockVelocity((0.3, 0.0, 0.0), 7.0)
    own = FlockVelocity((0.0, 0.1, 0.0), 8.0)
    assert law.flock_velocity(9.0, PATH, ORIGIN, own, estimates) == own
    assert law.flock_velocity(9.0, PATH, ORIGIN, NOTHING_HEARD, []) == NOTHING_HEARD
    mean = _law(estimates, relay="mean").flock_velocity(9.0, PATH, ORIGIN, NOTHING_HEARD, estimates)
    assert mean.velocity == pytest.approx((0.1, 0.05, 0.0))
    assert mean.stamp_s == 7.0


def test_leader_steers_the_centre_no_faster_than_it_knows_it():
    estimates = [_estimate(ORIGIN, age_s=10.0)]
    law = _law(estimates, is_leader=True, age_memory_s=1e-9)
    centre = (0.0, 1.0, 9.0)
    belief = law.flock_velocity(3.0, PATH, centre, NOTHING_HEARD, estimates)
    assert belief.stamp_s == 3.0
    assert belief.velocity == pytest.approx((0.1, 0.0, 2.0 * 0.3 / 10.0))
    far = law.flock_velocity(3.0, PATH, (0.0, 1.0, -90.0), belief, estimates)
    assert far.velocity == pytest.approx((0.1, 0.0, Params().steering_limit_mps))


def test_leader_steers_no_farther_within_one_age_than_its_reach():
    estimates = [_estimate(ORIGIN, age_s=30.0)]
    law = _law(estimates, is_leader=True, age_memory_s=1e-9, path_gain_ps=DISTANT)
    far = law.flock_velocity(3.0, PATH, (0.0, 1.0, -90.0), NOTHING_HEARD, estimates)
    assert far.velocity == pytest.approx((0.1, 0.0, Params().steering_reach_m / 30.0))


@MODERATE
@given(course_rad=st.floats(-3.0, 3.0), rate_radps=st.floats(-0.1, 0.1), ahead_s=st.floats(0.0, 60.0))
def test_the_velocity_that_a_leader_sets_follows_a_circle(course_rad, rate_radps, ahead_s):
    speed_mps = 0.4

    def path(course):
        velocity = (speed_mps * math.cos(course), speed_mps * math.sin(course), 0.02)
        return PathPoint(ORIGIN, velocity, (-velocity[1] * rate_radps, velocity[0] * rate_radps, 0.0))

    set_then = _law(is_leader=True).flock_velocity(3.0, path(course_rad), ORIGIN, NOTHING_HEARD, [])
    heard = _estimate(ORIGIN, heard=(set_then.velocity, set_then.stamp_s))
    heard = heard._replace(flock_turn_rate_radps=set_then.turn_rate_radps)
    passed_on = _law([heard]).flock_velocity(9.0, PATH, ORIGIN, NOTHING_HEARD, [heard])
    assert passed_on == set_then
    then = path(course_rad + rate_radps * ahead_s).velocity
    np.testing.assert_allclose(passed_on.at(3.0 + ahead_s), then, atol=1e-12)


@MODERATE
@given(distance_m=st.floats(0.3, 1.2), silence_s=st.floats(30.0, 300.0))
def test_a_vehicle_retreats_from_whom_it_knows_whatever_it_does_not_know_of_others(distance_m, silence_s):
    near = _estimate((distance_m, 0.0, 0.0))
    silent = _estimate((0.0, 6.0, 0.0), age_s=silence_s, address=3)
    asked = _correction(_law([near, silent]), _view(ORIGIN, [near, silent]))
    p = Params()
    retreat_mps = 0.5 * p.barrier_rate_ps * (p.barrier_distance_m - distance_m)
    assert asked[0] <= -min(retreat_mps, p.correction_limit_mps) + 1e-6


@MODERATE
@given(distance_m=st.floats(1.3, 3.0), closing_mps=st.floats(0.0, 0.4))
def test_a_vehicle_yields_to_a_neighbour_that_comes_nearer_by_more_than_its_half(distance_m, closing_mps):
    other = _estimate((distance_m, 0.0, 0.0), velocity=(W[0] - closing_mps, 0.0, 0.0))
    asked = _correction(_law([other]), _view(ORIGIN, [other], centre=(2.0, 0.0, 0.0)))
    p = Params()
    whole_mps = p.barrier_rate_ps * (distance_m - p.barrier_distance_m)
    allowed_mps = min(0.5 * whole_mps, whole_mps - closing_mps)
    assert asked[0] <= max(allowed_mps, -p.correction_limit_mps) + 1e-6


def test_flock_that_is_carried_towards_an_obstacle_stops_before_it():
    obstacles = (((1.3, 0.0, 0.0), 2.0),)
    asked = _law().velocity(_view(ORIGIN, [], obstacles=obstacles, centre=(0.5, 0.0, 0.0)))
    assert asked[0] <= 1e-9
    past = _law().velocity(_view(ORIGIN, [], obstacles=(((0.0, 9.0, 0.0), 2.0),), centre=ORIGIN))
    assert past == pytest.approx(W)


def test_same_place_gives_a_finite_answer():
    estimates = [_estimate(ORIGIN, age_s=3.0)]
    assert np.isfinite(_correction(_law(estimates), _view(ORIGIN, estimates))).all()


def test_separation_law_with_a_memory_learns():
    class Learner(mathematical.Separation):
        learned = None

        def adapt(self, distances_m, spacing_m, dt_s):
            self.learned = (distances_m, spacing_m, dt_s)

    learner = Learner(mathematical.Params())
    Flocking(Params(), learner, Member()).adapt(_view(ORIGIN, [_estimate((3.0, 0.0, 4.0))]), PERIOD_S)
    assert learner.learned == ([5.0], 2.0, PERIOD_S)


def test_barrier_outside_the_spacing_is_refused():
    with pytest.raises(ValueError, match=r"barrier_distance_m: 2.0 is not allowed; allowed: less than spa"):
        Params(barrier_distance_m=2.0)


@pytest.mark.parametrize("stated_m", [0.0, 0.2, 0.5, 3.0])
def test_what_navigations_state_widens_the_spacing_as_far_as_the_filter_shares_the_doubt(stated_m):
    estimate = _estimate((2.0, 0.0, 0.0), sigma_m=0.5)._replace(navigation_sd_m=stated_m)
    row = Estimates.of([estimate]).rows[0]
    law = _law([estimate], spacing_sigmas=2.0, navigation_sigmas=1.5, widening_limit_m=3.0)
    spacing_m = outlook(row, 0.0, ORIGIN, W, law._gains).spacing_m
    assert spacing_m == pytest.approx(2.0 + 2.0 * 0.5 + 1.5 * min(stated_m, 0.5))
    without = _law([estimate], navigation_sigmas=0.0)
    if stated_m == 0.0:
        assert law.velocity(_view(ORIGIN, [estimate])) == without.velocity(_view(ORIGIN, [estimate]))


def _sensed(place, velocity=(0.0, 0.0, 0.0), sigma_m=0.0):
    return SensedObstacle(1, place, velocity, sigma_m, 0.0, 2.0)


POINT = st.tuples(*[st.floats(-4.0, 4.0)] * 3)


@MODERATE
@given(POINT, POINT)
def test_a_sensed_obstacle_that_is_certain_and_still_counts_like_a_known_one(own, place):
    known = _law().velocity(_view(own, [], obstacles=((place, 2.0),)))
    sensed = _law().velocity(_view(own, [])._replace(sensed=(_sensed(place),)))
    assert known == sensed


@MODERATE
@given(st.floats(0.5, 3.0), st.floats(0.01, 0.2))
def test_a_vehicle_retreats_from_an_obstacle_that_comes_nearer_at_its_speed(distance_m, speed_mps):
    def ahead_mps(velocity):
        view = _view(ORIGIN, [], flock=ORIGIN, centre=(9.0, 0.0, 0.0))
        law = _law(correction_limit_mps=5.0, reach_m=1e3)
        return law.velocity(view._replace(sensed=(_sensed((distance_m, 0.0, 0.0), velocity),)))[0]

    still_mps = Params().barrier_rate_ps * (distance_m - Params().barrier_distance_m)
    assert ahead_mps((0.0, 0.0, 0.0)) <= still_mps + 1e-9
    assert ahead_mps((-speed_mps, 0.0, 0.0)) <= still_mps - speed_mps + 1e-9


@MODERATE
@given(st.floats(1.5, 2.5), st.floats(0.05, 1.0))
def test_an_uncertain_obstacle_is_kept_farther_away(distance_m, sigma_m):
    def ahead_mps(sigma):
        view = _view(ORIGIN, [], centre=(9.0, 0.0, 0.0))
        return _law().velocity(view._replace(sensed=(_sensed((distance_m, 0.0, 0.0), sigma_m=sigma),)))[0]

    assert ahead_mps(sigma_m) <= ahead_mps(0.0)


def _layered(address=1, *, fleet_size=4, estimates=(), **numbers):
    """Return the law of a vehicle with layers around 10 m, after a second with these estimates."""
    law = Flocking(Params(layer_depth_m=10.0, **numbers), SEPARATION, Member(False, address, fleet_size))
    law.hear(tuple(estimates), 1.0)
    return law


@settings(max_examples=20, deadline=None)
@given(fleet_size=st.integers(2, 128), span_m=st.floats(1.0, 18.0))
def test_every_vehicle_goes_to_a_depth_of_its_own(fleet_size, span_m):
    pitch_m = min(1.5, span_m / (fleet_size - 1))
    for address in {1, 2, max(fleet_size // 2, 1), fleet_size}:
        own_m = 10.0 + pitch_m * (address - 0.5 * (fleet_size + 1))
        law = _layered(address, fleet_size=fleet_size, layer_span_m=span_m)
        for off_m in (-0.2, 0.0, 0.2):
            view = _view((0.0, 0.0, own_m + off_m), [], centre=(3.0, 0.0, 0.0))
            assert _correction(law, view)[2] == pytest.approx(-0.3 * off_m, abs=1e-9)


def test_a_vehicle_that_has_not_heard_all_goes_straight_to_its_layer_and_then_with_the_flock():
    law, centre = _layered(), (3.0, 0.0, 7.75)
    on_the_way = law.velocity(_view((0.0, 0.0, 10.0), [], centre=centre))
    in_it = _correction(law, _view((0.0, 0.0, 7.75), [], centre=centre))
    assert on_the_way[2] < -0.1
    np.testing.assert_allclose(on_the_way[:2], 0.0, atol=1e-12)
    assert in_it[0] > 0.01
    np.testing.assert_allclose(in_it[1:], 0.0, atol=1e-12)


def test_before_all_have_settled_a_vehicle_that_has_not_heard_all_stays_where_it_reached_its_layer():
    view = _view((0.0, 0.0, 7.75), [], centre=(3.0, 0.0, 7.75))
    law = _layered(settling_s=80.0)
    np.testing.assert_allclose(law.velocity(view), 0.0, atol=1e-12)
    law.hear((), 79.0)
    assert law.velocity(view)[0] > 0.01


@MODERATE
@given(other=POINTS, velocity=SPEEDS, age_s=AGES)
def test_in_its_layer_a_vehicle_gives_way_sideways_only(other, velocity, age_s):
    neighbour = _estimate((other[0], other[1], 7.75 + other[2]), velocity=velocity, age_s=age_s)
    view = _view((0.0, 0.0, 7.75), [neighbour], centre=(3.0, 0.0, 7.75))
    assert _correction(_layered(), view)[2] == pytest.approx(0.0, abs=1e-12)


def test_with_a_time_of_silence_only_who_misses_one_takes_its_layer():
    heard = [_estimate((5.0 * k, 0.0, 10.0), address=k, age_s=2.0) for k in (2, 3, 4)]
    view = _view((0.0, 0.0, 10.0), heard, centre=(3.0, 0.0, 10.0))
    law = _layered(estimates=heard, silent_s=3.0)
    assert _correction(law, view)[2] == pytest.approx(0.0, abs=1e-12)
    old = [*heard[:2], heard[2]._replace(age_s=3.5)]
    assert _correction(_layered(estimates=old, silent_s=3.0), view)[2] < -0.1


def test_layers_above_the_surface_are_refused():
    with pytest.raises(
        ValueError, match=r"layer_depth_m: 3.0 is not allowed; allowed: more than half of lay"
    ):
        Params(layer_depth_m=3.0)


@pytest.mark.parametrize(
    ("distance_m", "expected_mps"), [(3.0, 0.045), (4.0, 0.06), (8.0, 0.18), (12.0, 0.3)]
)
def test_the_way_to_the_centre_from_outside_has_a_budget_of_its_own(distance_m, expected_mps):
    """At an age of 20 s: 0.3 / 20 per metre up to 4 m, and 0.6 / 20 for the share of the way outside."""
    far = [_estimate((30.0, 0.0, 0.0), age_s=20.0)]
    law = _law(far, age_memory_s=1e-9, correction_limit_mps=DISTANT, reach_m=DISTANT, barrier=False)
    asked = _correction(law, _view(ORIGIN, far, centre=(distance_m, 0.0, 0.0)))
    np.testing.assert_allclose(asked, [expected_mps, 0.0, 0.0], rtol=1e-9)


def _after(law, depth_m, *, n_known=0, running_s=0.0):
    """Return the law's horizontal speed in a current flock, and whether it stays, at a depth."""
    known = [_estimate((20.0 * (k + 1), 50.0, 10.0), address=2 + k) for k in range(n_known)]
    law.hear(tuple(known), running_s)
    view = _view((0.0, 0.0, depth_m), known, centre=(5.0, 0.0, 10.0))
    x, y, _ = law.velocity(view)
    law.adapt(view, PERIOD_S)
    return math.hypot(x, y), law.is_staying


@pytest.mark.parametrize(("n_known", "running_s"), [(3, 0.0), (0, 100.0), (3, 100.0)])
def test_a_vehicle_goes_straight_to_its_layer_first_whatever_it_knows(n_known, running_s):
    assert _after(_layered(settling_s=80.0), 9.0, n_known=n_known, running_s=running_s) == (0.0, True)


@pytest.mark.parametrize(
    ("n_known", "running_s", "stays"), [(3, 0.0, False), (2, 0.0, True), (2, 100.0, False)]
)
def test_in_its_layer_it_stays_until_it_has_heard_all_or_all_are_in_theirs(n_known, running_s, stays):
    speed_mps, is_staying = _after(_layered(settling_s=80.0), 7.75, n_known=n_known, running_s=running_s)
    assert is_staying == stays
    assert (speed_mps == 0.0) == stays


def test_one_that_has_been_in_its_layer_goes_on_when_it_is_pushed_out():
    law = _layered(settling_s=80.0)
    _after(law, 7.75, n_known=3)
    speed_mps, is_staying = _after(law, 8.5, n_known=3)
    assert speed_mps > 0.0
    assert not is_staying


def test_without_layers_and_with_layers_for_silence_only_it_goes_at_once():
    without = Flocking(Params(), SEPARATION, Member(False, 1, 4))
    for law in (without, _layered(silent_s=45.0)):
        assert _after(law, 9.0, n_known=3)[1] is False
