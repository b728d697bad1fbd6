"""Claims about the average that lost packets cannot bias."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lossy_network import Network, heard_estimate

from auv_flocking.codec import Layout
from auv_flocking.consensus import push_sum
from auv_flocking.consensus.push_sum import Consensus, Params

POINTS = st.tuples(*[st.floats(-50.0, 50.0)] * 3)
FOUR = [(0.0, 0.0, 10.0), (8.0, -3.0, 12.0), (-6.0, 9.0, 9.0), (3.0, 2.0, 15.0)]
BOOLS = pytest.mark.parametrize("follow_flock", [False, True])


def _network(positions=FOUR, *, quantise=False, follow_flock=False, **options):
    params = Params(quantise=quantise, follow_flock=follow_flock)
    return Network(lambda: Consensus(params, len(positions)), positions, **options)


def test_the_mean_is_kept_to_1e_9_with_six_of_ten_packets_lost():
    """Each of four vehicles sends 2000 times."""
    errors = _network(loss_prob=0.6, seed=1).run(8000)
    assert np.abs(errors[-4:]).max() < 1e-9
    assert np.abs(errors[-4000:].mean(axis=1)).max() < 1e-9


@pytest.mark.slow
@BOOLS
@pytest.mark.parametrize("seed", range(10))
def test_the_mean_is_kept_for_every_seed(seed, follow_flock):
    errors = _network(loss_prob=0.6, seed=seed, follow_flock=follow_flock).run(8000)
    assert np.abs(errors[-4000:]).max() < 1e-9


@settings(max_examples=6, deadline=None)
@given(
    st.lists(POINTS, min_size=2, max_size=5),
    st.floats(0.0, 0.8),
    st.integers(0, 10**6),
    st.integers(0, 5),
    st.booleans(),
)
def test_at_any_loss_all_estimates_go_to_the_mean(positions, loss_prob, seed, late, follow_flock):
    network = _network(positions, loss_prob=loss_prob, seed=seed, late=late, follow_flock=follow_flock)
    errors = network.run(600 * len(positions))
    assert np.abs(errors[-1]).max() < 1e-9


def test_losses_may_differ_from_link_to_link():
    """One vehicle hears one neighbour well and the others seldom: the graph is far from balanced."""
    loss_prob = {(1, 0): 0.2, (2, 0): 0.8, (3, 0): 0.8}
    network = _network(loss_prob=lambda source, destination: loss_prob.get((source, destination), 0.0))
    assert np.abs(network.run(1500)[-1]).max() < 1e-9


@BOOLS
@pytest.mark.parametrize("loss_prob", [0.0, 0.8])
def test_rounded_gifts_keep_the_mass_and_cost_millimetres(loss_prob, follow_flock):
    network = _network(quantise=True, is_packed=True, loss_prob=loss_prob, seed=1, follow_flock=follow_flock)
    errors = network.run(1200)
    assert np.abs(errors[-100:]).max() < (0.02 if follow_flock else 0.004)


def test_gifts_fit_their_fields_exactly_and_wrap_without_a_trace():
    positions = [tuple(3000.0 + x for x in point) for point in FOUR]
    network = _network(positions, quantise=True, is_packed=True, loss_prob=0.5, seed=2)
    errors = network.run(800)
    assert np.abs(errors[-100:]).max() < 0.02
    filters = network.filters
    layout = Layout(filters[0].shared_fields)
    sent = filters[0].shared()
    assert tuple(layout.unpack(layout.pack(sent))) == sent


def test_what_is_missed_for_long_comes_with_the_next_packet():
    one, other = (Consensus(Params(follow_flock=False), 2) for _ in range(2))
    here, there = (40.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    one.centre(here, [])
    other.centre(there, [])
    for _ in range(30):
        sums = one.shared()
    estimate = other.centre(
        there, [heard_estimate(1, here, here, age_s=0.0, flock_velocity=there, time_s=30.0, shared=sums)]
    )
    given = 1.0 - 0.5
    assert estimate[0] == pytest.approx(40.0 * given / (1.0 + given), abs=1e-3)
    again = other.centre(
        there, [heard_estimate(1, here, here, age_s=1.0, flock_velocity=there, time_s=30.0, shared=sums)]
    )
    assert again == estimate, "a packet that was taken counts no more"


def test_an_own_step_moves_the_estimate_as_it_will_move_the_mean():
    network = _network(FOUR)
    network.run(400)
    network.positions[2] += (4.0, -2.0, 1.0)
    before = network.centres[2].copy()
    errors = network.run(1)
    np.testing.assert_allclose(network.centres[2] - before, (1.0, -0.5, 0.25), atol=1e-9)
    assert np.abs(errors[-1][2]).max() < 1e-9
    assert np.abs(network.run(800)[-1]).max() < 1e-9


@pytest.mark.parametrize("loss_prob", [0.0, 0.6])
def test_with_the_flocks_velocity_a_moving_flock_is_followed_without_a_lag(loss_prob):
    velocity = (0.1, -0.05, 0.02)
    follows = _network(loss_prob=loss_prob, follow_flock=True, seed=3, late=2).run(900, velocity)
    trails = _network(loss_prob=loss_prob, follow_flock=False, seed=3, late=2).run(900, velocity)
    assert np.abs(follows[-100:]).max() < 1e-6
    assert np.abs(trails[-100:]).max() > 0.05


def test_frames_that_differ_are_drawn_together():
    """For 100 steps only one vehicle estimates that the flock moves."""
    network = _network(follow_flock=True, loss_prob=0.5, seed=5)
    moving = (0.1, 0.0, 0.0)
    network.run(100, believed=lambda index: moving if index == 0 else (0.0, 0.0, 0.0))
    assert np.abs(network.run(1200)[-1]).max() < 1e-9


def test_a_vehicle_that_hears_nothing_ends_the_mixing_and_no_number_blows_up():
    errors = _network(loss_prob=lambda _source, destination: float(destination == 3)).run(1200)
    assert np.abs(errors).max() < 30.0
    assert np.ptp(errors[-100:], axis=0).max() < 1e-9
    assert np.abs(errors[-1]).max() > 0.01


def test_a_fleet_of_one_is_its_own_centre():
    network = _network([(1.0, 2.0, 3.0)])
    errors = network.run(50, (0.1, 0.0, 0.0))
    assert np.abs(errors).max() < 1e-12


def test_the_packet_grows_by_what_is_shared():
    assert sum(field.bits for field in Consensus(Params(follow_flock=False), 4).shared_fields) == 113
    assert sum(field.bits for field in Consensus(Params(), 4).shared_fields) == 164
    steps = [field.resolution for field in Consensus(Params(), 4).shared_fields]
    assert all(np.log2(step).is_integer() for step in steps)
    assert push_sum.Params().uses_flock_velocity
