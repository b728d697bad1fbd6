"""Claims about the separation with adaptive repulsion."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.references import PathPoint
from auv_core.params import ConfigError, load
from auv_flocking.consensus import thesis
from auv_flocking.flocking import Member, View
from auv_flocking.flocking import potential as flocking
from auv_flocking.separation import fuzzy, mathematical
from auv_flocking.separation.adaptive_fuzzy import Params, Separation

MODERATE = settings(max_examples=60, deadline=None)
ORIGIN = (0.0, 0.0, 0.0)
STARTS = ((-8.0, 4.0, 2.0), (8.0, 2.0, 1.0), (-4.0, -8.0, 0.0), (6.0, 12.0, 4.0))
DISTANCES = st.lists(st.floats(0.0, 20.0), max_size=5)


def _fly(params, duration_s, period_s=0.1):
    """Fly four single integrators round the thesis's circle; return pair distances over time and the laws."""
    separations = [Separation(params) for _ in STARTS]
    laws = [flocking.Flocking(flocking.Params(), s, Member(i == 0)) for i, s in enumerate(separations)]
    consensus = thesis.Consensus(thesis.Params(), len(STARTS))
    places, centres, distances = list(STARTS), list(STARTS), []
    for tick in range(round(duration_s / period_s)):
        a = 0.01 * tick * period_s
        path = PathPoint(
            (10.0 * math.sin(a), 10.0 * math.cos(a), 10.0), (0.1 * math.cos(a), -0.1 * math.sin(a), 0.0)
        )
        others = [(tuple(places[:i] + places[i + 1 :]), centres[:i] + centres[i + 1 :]) for i in range(4)]
        views = [View(places[i], centres[i], ORIGIN, others[i][0], (), path) for i in range(4)]
        velocities = [law.velocity(view) for law, view in zip(laws, views, strict=True)]
        for law, view in zip(laws, views, strict=True):
            law.adapt(view, period_s)
        centres = [consensus.step(places[i], centres[i], others[i][1], ORIGIN, period_s) for i in range(4)]
        places = [
            tuple(np.add(p, np.multiply(period_s, v)).tolist())
            for p, v in zip(places, velocities, strict=True)
        ]
        distances.append([math.dist(places[i], places[j]) for i in range(4) for j in range(i)])
    return np.array(distances), separations


def test_it_drives_the_distances_to_the_spacing_at_a_period_of_a_tenth_of_a_second():
    distances_m, separations = _fly(Params(), 100.0)
    np.testing.assert_allclose(distances_m[-1], 2.0, atol=0.02)
    assert distances_m.min() > 1.0
    assert all(law.output_peaks_mps[2] == pytest.approx(-0.9, abs=0.05) for law in separations)


def test_without_adaptation_the_same_sets_leave_the_flock_too_near():
    """The push at d that four vehicles need, K d / n = 0.9, is what the peaks above have learnt."""
    distances_m, _ = _fly(Params(adaptation_rate_ps2=0.0), 40.0)
    assert distances_m[-1].max() < 1.7


def test_at_rest_it_is_the_fuzzy_law():
    peaks = Params().input_peaks_m
    plain = fuzzy.Separation(fuzzy.Params(input_peaks_m=peaks))
    law = Separation(Params())
    for x in np.linspace(0.1, 8.0, 50).tolist():
        own = (x, 0.3, -0.2)
        assert law.velocity(own, ORIGIN, 2.0) == plain.velocity(own, ORIGIN, 2.0)
        assert law.obstacle_velocity(own, ORIGIN, 2.0) == plain.obstacle_velocity(own, ORIGIN, 2.0)


@MODERATE
@given(st.lists(DISTANCES, max_size=40), st.floats(0.01, 20.0))
def test_the_peaks_stay_in_order_and_within_their_bound(history, dt_s):
    law = Separation(Params(adaptation_rate_ps2=5.0))
    for distances_m in history:
        law.adapt(distances_m, 2.0, dt_s)
        moved = np.subtract(law.output_peaks_mps, Params().output_peaks_mps)
        assert np.diff(law.output_peaks_mps).min() > 0.0
        assert np.abs(moved).max() <= Params().shift_max_mps + 1e-12


@MODERATE
@given(DISTANCES)
def test_too_near_pushes_more_and_too_far_less(distances_m):
    law = Separation(Params())
    law.adapt(distances_m, 2.0, 0.1)
    near = [d - 2.0 for d in distances_m if abs(d - 2.0) < Params().reach_m]
    mean_m = sum(near) / len(near) if near else 0.0
    assert law.shift_mps == pytest.approx(0.1 * Params().adaptation_rate_ps2 * max(min(mean_m, 0.5), -0.5))


def test_the_bound_is_met_and_left_at_once():
    law = Separation(Params())
    for _ in range(10_000):
        law.adapt([1.5], 2.0, 0.1)
    assert law.shift_mps == -Params().shift_max_mps
    law.adapt([2.4], 2.0, 0.1)
    assert law.shift_mps > -Params().shift_max_mps


def test_obstacles_are_met_with_peaks_at_rest():
    law = Separation(Params())
    before = law.obstacle_velocity((1.0, 0.0, 0.0), ORIGIN, 2.0)
    for _ in range(100):
        law.adapt([1.5], 2.0, 0.1)
    assert law.obstacle_velocity((1.0, 0.0, 0.0), ORIGIN, 2.0) == before
    assert law.velocity((1.0, 0.0, 0.0), ORIGIN, 2.0)[0] > before[0]


def test_laws_without_a_memory_have_nothing_to_learn():
    law = flocking.Flocking(
        flocking.Params(), mathematical.Separation(mathematical.Params()), Member(is_leader=True)
    )
    view = View(ORIGIN, ORIGIN, ORIGIN, ((1.0, 0.0, 0.0),), (), PathPoint(ORIGIN, ORIGIN))
    before = law.velocity(view)
    law.adapt(view, 0.1)
    assert law.velocity(view) == before


def test_sets_out_of_order_are_refused():
    with pytest.raises(ConfigError, match=r"^x\.output_peaks_mps: .* allowed: five ascending numbers"):
        load(Params, {"output_peaks_mps": [-2.0, -1.0, 0.0, 0.0, 2.0]}, "x")
