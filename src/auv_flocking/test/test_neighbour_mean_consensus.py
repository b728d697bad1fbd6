"""Claims about the mean of estimated positions."""

import numpy as np
import pytest
from lossy_network import Network, heard_estimate

from auv_flocking.consensus.neighbour_mean import Consensus, Params

FOUR = [(0.0, 0.0, 10.0), (8.0, -3.0, 12.0), (-6.0, 9.0, 9.0), (3.0, 2.0, 15.0)]


def _heard(position):
    return heard_estimate(2, position, (9.0, 9.0, 9.0))


def test_it_is_the_mean_of_the_own_position_and_those_heard():
    law = Consensus(Params(), 4)
    assert law.centre((1.0, 2.0, 3.0), []) == (1.0, 2.0, 3.0)
    assert law.centre((1.0, 2.0, 3.0), [_heard((4.0, 2.0, 0.0)), _heard((4.0, 2.0, 0.0))]) == (3.0, 2.0, 1.0)
    assert law.shared() == law.shared_fields == ()


@pytest.mark.parametrize("loss_prob", [0.0, 0.6])
def test_once_all_are_heard_it_is_exact_for_what_moves_as_is_believed(loss_prob):
    network = Network(lambda: Consensus(Params(), 4), FOUR, loss_prob=loss_prob)
    assert np.abs(network.run(100, (0.1, 0.0, 0.0))[-1]).max() < 1e-9


def test_a_vehicle_that_is_not_heard_is_left_out():
    network = Network(lambda: Consensus(Params(), 4), FOUR, loss_prob=lambda source, _to: float(source == 3))
    network.run(20)
    np.testing.assert_allclose(network.centres[0], np.mean(FOUR[:3], axis=0))
    np.testing.assert_allclose(network.centres[3], np.mean(FOUR, axis=0))


def test_the_rate_is_the_flocks_or_none():
    assert Consensus(Params(), 4).advance((0.0,) * 3, [], (0.1, 0.2, 0.3), 0.1) == (0.1, 0.2, 0.3)
    still = Params(follow_flock=False)
    assert Consensus(still, 4).advance((0.0,) * 3, [], (0.1, 0.2, 0.3), 0.1) == (0.0, 0.0, 0.0)
    assert not still.uses_flock_velocity
