"""Claims about the proportional-integral consensus filter."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lossy_network import Network

from auv_core.params import ConfigError, load
from auv_flocking.consensus.pi import Consensus, Params

FOUR = [(0.0, 0.0, 10.0), (8.0, -3.0, 12.0), (-6.0, 9.0, 9.0), (3.0, 2.0, 15.0)]
LINE = {(0, 1), (1, 0), (1, 2), (2, 1), (2, 3), (3, 2)}


def _network(positions=FOUR, params=None, **options):
    params = params or Params()
    return Network(lambda: Consensus(params, len(positions)), positions, **options)


@pytest.mark.parametrize(("loss_prob", "steps"), [(0.0, 700), (0.6, 1200)])
def test_for_vehicles_at_rest_no_error_is_left(loss_prob, steps):
    """Also where losses make the graph of one cycle directed and change it in the next."""
    errors = _network(loss_prob=loss_prob, late=1).run(steps)
    assert np.abs(errors[-1]).max() < 1e-5


def test_a_chain_of_vehicles_is_enough():
    network = _network(loss_prob=lambda source, destination: float((source, destination) not in LINE))
    errors = np.abs(network.run(5000)).max(axis=(1, 2))
    assert errors[-1] < 0.01
    assert errors[-1] < 0.1 * errors[2500], "still on its way to nothing"


def test_a_vehicle_that_is_cut_off_is_left_out_of_the_mean():
    network = _network(loss_prob=lambda source, destination: float(3 in (source, destination)))
    errors = network.run(2500) + np.mean(FOUR, axis=0)
    np.testing.assert_allclose(errors[-1][:3], np.tile(np.mean(FOUR[:3], axis=0), (3, 1)), atol=1e-2)
    np.testing.assert_allclose(errors[-1][3], FOUR[3], atol=1e-2)


def test_what_the_integrals_began_with_is_forgotten():
    network = _network()
    for index, item in enumerate(network.filters):
        item._integral = (50.0 * index, -30.0, 900.0)
    assert np.abs(network.run(1200)[-1]).max() < 1e-5


def test_packets_cost_centimetres_at_most():
    errors = _network(loss_prob=0.3, is_packed=True).run(1500)
    assert np.abs(errors[-200:]).max() < 0.05


def test_integrals_may_wrap():
    network = _network()
    for item in network.filters:
        item._integral = (1023.9, -1023.9, 0.0)
    assert np.abs(network.run(1200)[-1]).max() < 1e-5


@pytest.mark.parametrize("follow_flock", [False, True])
def test_a_moving_flock_is_followed_without_a_lag_only_with_its_velocity(follow_flock):
    velocity = (0.1, -0.05, 0.02)
    network = _network(params=Params(follow_flock=follow_flock), loss_prob=0.3, late=1)
    error = np.abs(network.run(1000, velocity)[-50:]).max()
    assert (error < 1e-4) if follow_flock else (error > 0.1)


@settings(max_examples=50, deadline=None)
@given(st.floats(0.05, 5.0), st.floats(0.0, 5.0), st.floats(0.5, 60.0), st.integers(2, 16))
def test_gains_at_the_limit_are_stable_up_to_the_age_that_is_asked_for(
    rate_ps, agreement_ps, oldest_s, count
):
    integral_ps = 0.999 * (0.5 * rate_ps / oldest_s) ** 0.5
    params = Params(rate_ps, agreement_ps, integral_ps, oldest_s)
    degree = (count - 1) / count
    for weight in (degree, 0.5 * degree, -1.0 / count, -0.5 * degree):
        for age_s in (0.1 * oldest_s, 0.5 * oldest_s, oldest_s):
            assert _unstable_roots(params, degree, weight, age_s) == 0


def test_the_defaults_are_stable_up_to_24_s_on_every_graph():
    for count in (2, 3, 4, 8, 16):
        degree = (count - 1) / count
        for weight in np.linspace(-degree, degree, 9):
            for age_s in (0.0, 1.0, 4.0, 8.0, 16.0, 24.0):
                assert _unstable_roots(Params(), degree, weight, age_s) == 0
    assert _unstable_roots(Params(), 0.875, -0.875, 40.0) > 0, "and not without end"


def _unstable_roots(params, degree, weight, age_s):
    """Return how many roots of a mode have a positive real part, by the principle of the argument."""
    g, kp, ki = params.input_rate_ps, params.agreement_rate_ps, params.integral_rate_ps
    radius = 10.0 * (g + 2.0 * kp + 2.0 * ki + 1.0)
    turn = np.linspace(-0.5, 0.5, 600) * np.pi
    line = np.concatenate(
        [np.geomspace(1e-5, 1e-2, 300), np.arange(1e-2, radius, min(0.02, 0.2 / (age_s + 0.1)))]
    )
    s = np.concatenate([-1j * line[::-1], 1e-5 * np.exp(1j * turn), 1j * line, radius * np.exp(-1j * turn)])
    late = degree - weight * np.exp(-s * age_s)
    value = s * s + s * (g + kp * late) + (ki * late) ** 2
    angle = np.unwrap(np.angle(np.append(value, value[0])))
    return round((angle[0] - angle[-1]) / (2.0 * np.pi))


def test_gains_too_fast_for_old_news_are_refused():
    with pytest.raises(
        ConfigError, match=r"x\.integral_rate_ps: 0.5 is not allowed; allowed: at most 0.1768"
    ):
        load(Params, {"integral_rate_ps": 0.5}, "x")


def test_a_packet_carries_three_numbers_more():
    fields = Consensus(Params(), 4).shared_fields
    assert [field.bits for field in fields] == [16, 16, 16]
