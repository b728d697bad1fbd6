"""
A modem whose range is limited by noise: sonar equation, signal to noise, bit errors, packet errors.

SNR = SL - TL - (NL + 10 log10 B), with source level SL, transmission loss TL of the propagation, ambient
noise NL at the carrier (turbulence, shipping, wind, thermal; Coates) and band B. Interfering packets add to
the noise. Ambient noise is computed here, since only a modem with sound levels needs it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.modem import LevelModem
from auv_sim.acoustics.water import (
    ambient_noise_db,
    bpsk_bit_error_prob,
    fsk_bit_error_prob,
    source_level_db,
)

_BIT_ERRORS = {"bpsk": bpsk_bit_error_prob, "fsk": fsk_bit_error_prob}


@dataclass(frozen=True)
class Params:
    """Transmitter, signal, receiver and noise."""

    source_level_db: float | None = param(
        "source level (dB re 1 uPa at 1 m); null: from power_w and directivity_db",
        default=None, minimum=0.0, maximum=250.0,
    )  # fmt: skip
    power_w: float = param(
        "acoustic power (W), used if source_level_db is null", default=5.0, above=0.0, maximum=1e6
    )
    directivity_db: float = param(
        "directivity index of the transmitter (dB), used if source_level_db is null",
        default=0.0,
        minimum=-60.0,
        maximum=60.0,
    )
    carrier_hz: float = param("centre of the band (Hz)", default=25000.0, minimum=10.0, maximum=1e6)
    bandwidth_hz: float = param("width of the band (Hz)", default=5000.0, minimum=1.0, maximum=1e6)
    modulation: str = param(
        "bpsk (coherent) or fsk (non-coherent), both binary", default="bpsk", choices=tuple(_BIT_ERRORS)
    )
    bit_rate_bps: float = param("bits per second on the air", default=5000.0, above=0.0)
    preamble_s: float = param("time on the air before the first bit (s)", default=0.0, minimum=0.0)
    max_payload_bytes: int = param("largest payload (bytes)", default=128, minimum=1, maximum=65535)
    acquisition_db: float = param(
        "smallest ratio of signal to noise and interference (dB) at which the start of a packet is "
        "recognised",
        default=0.0, minimum=-60.0, maximum=60.0,
    )  # fmt: skip
    capture: bool = param(
        "whether a receiver keeps the packet that it has locked on to when another one comes", default=True
    )
    shipping_ratio: float = param("ship traffic, 0 none to 1 heavy", default=0.5, minimum=0.0, maximum=1.0)
    wind_mps: float = param("wind at the surface (m/s)", default=0.0, minimum=0.0, maximum=100.0)


class Modem(LevelModem):
    """Ratios are relative to the ambient noise in the band: 1 is as loud as the noise."""

    max_range_m = math.inf

    def __init__(self, params: Params) -> None:
        self._params = params
        self.max_payload_bytes = params.max_payload_bytes
        self.preamble_s = params.preamble_s
        self.captures = params.capture
        self.frequency_khz = params.carrier_hz / 1000.0
        level_db = params.source_level_db
        if level_db is None:
            level_db = source_level_db(params.power_w, params.directivity_db)
        noise_db = ambient_noise_db(self.frequency_khz, params.shipping_ratio, params.wind_mps)
        self._snr_at_source_db = level_db - noise_db - 10.0 * math.log10(params.bandwidth_hz)
        self._acquisition_ratio = 10.0 ** (0.1 * params.acquisition_db)
        self._bit_error_prob = _BIT_ERRORS[params.modulation]

    def airtime_s(self, payload_bytes: int) -> float:
        """Return the time on the air (s) of a payload."""
        return self._params.preamble_s + 8.0 * payload_bytes / self._params.bit_rate_bps

    def snr_ratio(self, loss_db: float) -> float:
        """Return signal to ambient noise in the band after a transmission loss (dB), as a power ratio."""
        return 10.0 ** (0.1 * (self._snr_at_source_db - loss_db))

    def acquires(self, snr_ratio: float) -> bool:
        """Return whether a packet's start is recognised at this ratio of signal to noise and interference."""
        return snr_ratio >= self._acquisition_ratio

    def bit_error_prob(self, snr_ratio: float) -> float:
        """Return the probability of an error of one bit, by the modulation."""
        return self._bit_error_prob(snr_ratio)
