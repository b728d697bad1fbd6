"""
Closed formulas of underwater sound: speed, absorption, spreading, ambient noise, bit errors.

Levels are dB re 1 uPa at 1 m, noise is dB re 1 uPa^2/Hz, frequencies of the formulas are in kHz.

Sources: Mackenzie, J. Acoust. Soc. Am. 70 (1981) 807; Thorp, J. Acoust. Soc. Am. 42 (1967) 270; Coates,
Underwater Acoustic Systems (1990), in the form of Stojanovic, On the relationship between capacity and
distance in an underwater acoustic communication channel, ACM SIGMOBILE 11 (2007) 34; Proakis, Digital
Communications.

Eb/N0 is the energy of a bit of data over the noise in 1 Hz. From the signal to noise ratio in a band of B Hz
it follows as SNR x B / R with R bits of data per second: a slow signal in a wide band gains.
"""

from __future__ import annotations

import math


def sound_speed_mps(temperature_c: float, salinity_ppt: float, depth_m: float) -> float:
    """
    Return the speed of sound in sea water (m/s), Mackenzie (1981).

    Fitted for 2 to 30 degrees Celsius, 25 to 40 parts per thousand and 0 to 8000 m.
    """
    t, s, d = temperature_c, salinity_ppt - 35.0, depth_m
    return (
        1448.96 + 4.591 * t - 5.304e-2 * t**2 + 2.374e-4 * t**3
        + 1.340 * s + 1.630e-2 * d + 1.675e-7 * d**2
        - 1.025e-2 * t * s - 7.139e-13 * t * d**3
    )  # fmt: skip


def absorption_db_per_km(frequency_khz: float) -> float:
    """Return the absorption of sea water (dB/km), Thorp's formula for a few hundred hertz and above."""
    f2 = frequency_khz * frequency_khz
    return 0.11 * f2 / (1.0 + f2) + 44.0 * f2 / (4100.0 + f2) + 2.75e-4 * f2 + 0.003


def transmission_loss_db(range_m: float, frequency_khz: float, spreading_exponent: float) -> float:
    """
    Return spreading and absorption over a range (dB); a range below 1 m counts as 1 m.

    The exponent k of 10 k log10(range / 1 m) is 2 for spherical, 1 for cylindrical, 1.5 for practical
    spreading.
    """
    spreading_db = 10.0 * spreading_exponent * math.log10(max(range_m, 1.0))
    return spreading_db + absorption_db_per_km(frequency_khz) * range_m / 1000.0


def ambient_noise_db(frequency_khz: float, shipping_ratio: float, wind_mps: float) -> float:
    """
    Return the level of ambient noise at a frequency (dB re 1 uPa^2/Hz): four sources, summed as power.

    Parameters
    ----------
    frequency_khz : float
        Above zero.
    shipping_ratio : float
        From 0, no ships, to 1, heavy traffic.
    wind_mps : float
        Speed of the wind at the surface.

    """
    log_f = math.log10(frequency_khz)
    terms_db = (
        17.0 - 30.0 * log_f,  # turbulence
        40.0 + 20.0 * (shipping_ratio - 0.5) + 26.0 * log_f - 60.0 * math.log10(frequency_khz + 0.03),
        50.0 + 7.5 * math.sqrt(wind_mps) + 20.0 * log_f - 40.0 * math.log10(frequency_khz + 0.4),
        -15.0 + 20.0 * log_f,  # thermal
    )
    return 10.0 * math.log10(sum(10.0 ** (0.1 * term_db) for term_db in terms_db))


def source_level_db(power_w: float, directivity_db: float = 0.0) -> float:
    """Return the source level (dB re 1 uPa at 1 m) of an acoustic power, 170.8 + 10 log10(P / 1 W) + DI."""
    return 170.8 + 10.0 * math.log10(power_w) + directivity_db


def bpsk_bit_error_prob(ebn0_ratio: float) -> float:
    """Return the bit error probability of coherent binary phase-shift keying, 0.5 erfc(sqrt(Eb/N0))."""
    return 0.5 * math.erfc(math.sqrt(ebn0_ratio))


def fsk_bit_error_prob(ebn0_ratio: float) -> float:
    """Return the bit error probability of non-coherent binary frequency-shift keying, 0.5 exp(-Eb/(2 N0))."""
    return 0.5 * math.exp(-0.5 * ebn0_ratio)


def packet_error_prob(bit_error_prob: float, bits: float) -> float:
    """Return 1 - (1 - BER)^bits, accurate even for very small values."""
    return -math.expm1(bits * math.log1p(-bit_error_prob))
