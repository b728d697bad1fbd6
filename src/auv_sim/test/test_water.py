"""Claims about the closed formulas of underwater sound."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_sim.acoustics import water
from auv_sim.acoustics.modem.noise_limited import Modem, Params
from auv_sim.acoustics.propagation import mackenzie

MODERATE = settings(max_examples=60, deadline=None)
KHZ = st.floats(0.1, 200.0)


def _desert(wind_mps, bit_rate_bps=5e3):
    """
    Return the modem of the swarm sample of DESERT: 156 dB, 40 kHz, 5 kHz of band, BPSK.

    DESERT puts the ratio within the band where Eb/N0 belongs, whatever the bit rate (its sample: 200 bit/s).
    That is right for as many bits per second as the band has hertz.
    """
    return Modem(
        Params(
            source_level_db=156.0, carrier_hz=40e3, bandwidth_hz=5e3, bit_rate_bps=bit_rate_bps,
            modulation="bpsk", wind_mps=wind_mps, shipping_ratio=0.5,
        )
    )  # fmt: skip


def _packet_error_prob(modem, range_m, *, spreading_exponent, payload_bytes=32):
    loss_db = water.transmission_loss_db(range_m, modem.frequency_khz, spreading_exponent)
    return -math.expm1(modem.log_success(modem.snr_ratio(loss_db), payload_bytes))


@pytest.mark.parametrize(("frequency_khz", "db_per_km"), [(10.0, 1.187), (25.0, 6.105)])
def test_absorption_is_thorps(frequency_khz, db_per_km):
    assert water.absorption_db_per_km(frequency_khz) == pytest.approx(db_per_km, abs=5e-4)


def test_sound_speed_is_mackenzies():
    assert water.sound_speed_mps(25.0, 35.0, 1000.0) == pytest.approx(1550.744, abs=1e-3)


def test_sound_is_faster_in_warm_salt_and_deep_water():
    cold = water.sound_speed_mps(4.0, 35.0, 10.0)
    assert water.sound_speed_mps(14.0, 35.0, 10.0) > cold + 30.0
    assert water.sound_speed_mps(4.0, 40.0, 10.0) > cold + 5.0
    assert water.sound_speed_mps(4.0, 35.0, 1010.0) == pytest.approx(cold + 16.5, abs=0.5)


def test_mackenzie_delays_are_those_of_the_depth():
    propagation = mackenzie.Propagation(mackenzie.Params(temperature_c=12.0, gradient_c_per_m=-0.05))
    for depth_m in (-1.0, 5.0, 100.0):
        speed_mps = 1500.0 / propagation.delay_s((0.0, 0.0, depth_m), (1500.0, 0.0, depth_m))
        wet_m = max(depth_m, 0.0)
        assert speed_mps == pytest.approx(water.sound_speed_mps(12.0 - 0.05 * wet_m, 35.0, wet_m))


def test_spreading_and_absorption_add_up_from_one_metre_on():
    assert water.transmission_loss_db(1000.0, 10.0, 1.5) == pytest.approx(45.0 + 1.187, abs=1e-3)
    assert water.transmission_loss_db(0.0, 10.0, 1.5) == 0.0
    assert water.transmission_loss_db(0.5, 10.0, 2.0) == pytest.approx(0.0, abs=1e-3)


@MODERATE
@given(st.floats(0.0, 1e8), st.floats(0.0, 1e8), KHZ, st.floats(1.0, 2.0))
def test_what_comes_from_farther_is_weaker(near_m, far_m, frequency_khz, exponent):
    near_m, far_m = sorted((near_m, far_m))
    losses = [water.transmission_loss_db(r, frequency_khz, exponent) for r in (near_m, far_m)]
    assert 0.0 <= losses[0] <= losses[1] < math.inf


@pytest.mark.parametrize(
    ("frequency_khz", "shipping_ratio", "wind_mps", "level_db"),
    [
        # By hand, from the four terms: turbulence, shipping, wind and thermal noise each where it rules.
        (0.001, 0.0, 0.0, 107.0), (0.1, 1.0, 0.0, 77.2), (1.0, 0.0, 10.0, 67.9), (1000.0, 0.0, 0.0, 45.0),
    ],
)  # fmt: skip
def test_each_source_of_noise_rules_its_band(frequency_khz, shipping_ratio, wind_mps, level_db):
    level = water.ambient_noise_db(frequency_khz, shipping_ratio, wind_mps)
    assert level == pytest.approx(level_db, abs=0.3)


@MODERATE
@given(KHZ, st.floats(0.0, 1.0), st.floats(0.0, 40.0))
def test_wind_and_ships_make_noise(frequency_khz, shipping_ratio, wind_mps):
    calm = water.ambient_noise_db(frequency_khz, 0.0, 0.0)
    assert calm <= water.ambient_noise_db(frequency_khz, shipping_ratio, wind_mps) < math.inf


def test_a_watt_is_170_8_db():
    assert water.source_level_db(1.0) == pytest.approx(170.8)
    assert water.source_level_db(100.0, 3.0) == pytest.approx(193.8)


@pytest.mark.parametrize("bit_error_prob", [water.bpsk_bit_error_prob, water.fsk_bit_error_prob])
def test_bit_errors_fall_from_a_coin_toss_to_nothing(bit_error_prob):
    values = [bit_error_prob(10.0 ** (0.1 * db)) for db in np.linspace(-60.0, 60.0, 241)]
    assert values == sorted(values, reverse=True)
    assert bit_error_prob(0.0) == 0.5
    assert values[-1] == 0.0


@pytest.mark.parametrize(
    ("bit_error_prob", "ebn0_db"),
    [(water.bpsk_bit_error_prob, 9.59), (water.fsk_bit_error_prob, 13.35)],
)
def test_one_bit_in_100000_is_wrong_at_the_textbooks_ebn0(bit_error_prob, ebn0_db):
    """Proakis, Digital Communications: coherent BPSK at 9.6 dB, non-coherent binary FSK at 13.35 dB."""
    assert bit_error_prob(10.0 ** (0.1 * ebn0_db)) == pytest.approx(1e-5, rel=0.02)


@MODERATE
@given(st.floats(0.0, 0.5), st.integers(0, 20000))
def test_packet_errors_are_probabilities_and_grow_with_bits(bit_error_prob, bits):
    value = water.packet_error_prob(bit_error_prob, bits)
    assert 0.0 <= value <= 1.0
    assert value <= water.packet_error_prob(bit_error_prob, bits + 8)
    assert value == pytest.approx(1.0 - (1.0 - bit_error_prob) ** bits, abs=1e-9)


@pytest.mark.parametrize(("wind_mps", "heard_m", "lost_m"), [(0.0, 2000.0, 3000.0), (5.0, 1500.0, 2000.0)])
def test_the_cliff_of_deserts_sample_lies_where_it_should(wind_mps, heard_m, lost_m):
    modem = _desert(wind_mps)
    assert _packet_error_prob(modem, heard_m, spreading_exponent=1.75) < 0.01
    assert _packet_error_prob(modem, lost_m, spreading_exponent=1.75) > 0.99


def test_deserts_sample_reaches_farther_with_the_energy_that_its_bits_have():
    """200 bit/s in 5 kHz gain 14 dB, so the cliff lies where the level is 14 dB lower."""
    slow, fast = _desert(0.0, bit_rate_bps=200.0), _desert(0.0)
    assert _packet_error_prob(slow, 3000.0, spreading_exponent=1.75) < 0.01
    for range_m in (2300.0, 2400.0, 2500.0):
        weaker = fast.snr_ratio(water.transmission_loss_db(range_m, 40.0, 1.75)) / 25.0
        assert slow.log_success(weaker, 32) == pytest.approx(fast.log_success(25.0 * weaker, 32), rel=1e-9)


def test_no_level_carries_sound_without_end():
    modem = _desert(0.0)
    ranges_m = np.geomspace(1.0, 1e8, 400)
    values = [_packet_error_prob(modem, range_m, spreading_exponent=1.5) for range_m in ranges_m]
    assert values == sorted(values)
    assert values[0] == 0.0
    assert all(
        value == pytest.approx(1.0) for range_m, value in zip(ranges_m, values, strict=True) if range_m > 5e3
    )
    assert not modem.acquires(modem.snr_ratio(water.transmission_loss_db(1e8, 40.0, 1.5)))


def test_packets_fail_by_bits_not_bytes():
    modem = _desert(0.0)
    range_m = 2450.0
    one = _packet_error_prob(modem, range_m, spreading_exponent=1.75, payload_bytes=1)
    bit_error_prob = 1.0 - (1.0 - one) ** (1.0 / 8.0)
    loss_db = water.transmission_loss_db(range_m, 40.0, 1.75)
    assert bit_error_prob == pytest.approx(water.bpsk_bit_error_prob(modem.snr_ratio(loss_db)))


def test_a_source_level_comes_from_decibels_or_watts():
    loud, same = (
        Modem(params).snr_ratio(60.0)
        for params in (Params(source_level_db=180.8), Params(power_w=10.0))
    )  # fmt: skip
    assert loud == pytest.approx(same)
    assert Modem(Params(power_w=10.0, directivity_db=10.0)).snr_ratio(60.0) == pytest.approx(10.0 * loud)
