"""
A modem whose range is limited by noise: sonar equation, signal to noise, bit errors, packet errors.

In the band B: SNR = SL - TL - (NL + 10 log10 B), with source level SL, transmission loss TL of the
propagation and ambient noise NL at the carrier (turbulence, shipping, wind, thermal; Coates). Interfering
packets add to the noise. Ambient noise is computed here, since only a modem with sound levels needs it.

Errors follow in one of two ways:

1. From a modulation and a code: a bit of data has Eb/N0 = SNR x B / R at R bits of data per second. The
   interference within the band counts as noise, so it is weakened by B / R too.
2. From frame errors that were published for the modem (`frame_error_snr_db`, `frame_error_probs`), linear
   between points. They hold for SNR in the band, and already contain modulation, code and receiver.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

from auv_core.params import param
from auv_sim.acoustics.codes import CODES
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
    code: str = param("error-correcting code", default="none", choices=tuple(CODES))
    bit_rate_bps: float = param("bits of data per second on the air", default=5000.0, above=0.0)
    frame_error_snr_db: tuple[float, ...] = param(
        "signal to noise and interference in the band (dB), increasing, at which frame_error_probs are "
        "known; empty: errors follow from modulation and code",
        default=(), minimum=-60.0, maximum=60.0,
    )  # fmt: skip
    frame_error_probs: tuple[float, ...] = param(
        "error probability of a frame at each of frame_error_snr_db, falling; linear between them",
        default=(), minimum=0.0, maximum=1.0,
    )  # fmt: skip
    frame_bytes: int = param(
        "a payload is filled up to whole frames of this size (bytes)", default=1, minimum=1, maximum=65535
    )
    packet_s: float | None = param(
        "time on the air of every packet (s), preamble included, whatever is in it; null: preamble_s and "
        "the bits of its frames",
        default=None, above=0.0,
    )  # fmt: skip
    preamble_s: float = param("time on the air before the first bit (s)", default=0.0, minimum=0.0)
    max_payload_bytes: int = param("largest payload (bytes)", default=128, minimum=1, maximum=65535)
    acquisition_db: float = param(
        "smallest ratio of signal to noise and interference in the band (dB) at which the start of a packet "
        "is recognised",
        default=0.0, minimum=-60.0, maximum=60.0,
    )  # fmt: skip
    capture: bool = param(
        "whether a receiver keeps the packet that it has locked on to when another one comes", default=True
    )
    shipping_ratio: float = param("ship traffic, 0 none to 1 heavy", default=0.5, minimum=0.0, maximum=1.0)
    wind_mps: float = param("wind at the surface (m/s)", default=0.0, minimum=0.0, maximum=100.0)

    def __post_init__(self) -> None:
        """Refuse a packet that is shorter than its preamble, and frame errors that are no curve."""
        if self.packet_s is not None and self.packet_s <= self.preamble_s:
            raise ValueError(
                f"packet_s: {self.packet_s!r} is not allowed; "
                f"allowed: more than preamble_s = {self.preamble_s!r}"
            )
        levels_db, probs = self.frame_error_snr_db, self.frame_error_probs
        if len(levels_db) != len(probs):
            raise ValueError(
                f"frame_error_probs: {len(probs)} values are not allowed; "
                f"allowed: one for each of the {len(levels_db)} of frame_error_snr_db"
            )
        if any(b <= a for a, b in pairwise(levels_db)):
            raise ValueError(f"frame_error_snr_db: {list(levels_db)} is not allowed; allowed: increasing")
        if any(b > a for a, b in pairwise(probs)):
            raise ValueError(f"frame_error_probs: {list(probs)} is not allowed; allowed: falling")


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
        self._code = CODES[params.code]
        self._ebn0_per_snr = params.bandwidth_hz / params.bit_rate_bps

    def airtime_s(self, payload_bytes: int) -> float:
        """Return the time on the air (s) of a payload."""
        if self._params.packet_s is not None:
            return self._params.packet_s
        bits = 8.0 * self._params.frame_bytes * self._frames(payload_bytes)
        return self._params.preamble_s + bits / self._params.bit_rate_bps

    def snr_ratio(self, loss_db: float) -> float:
        """Return signal to ambient noise in the band after a transmission loss (dB), as a power ratio."""
        return 10.0 ** (0.1 * (self._snr_at_source_db - loss_db))

    def acquires(self, snr_ratio: float) -> bool:
        """Return whether a packet's start is recognised at this ratio of signal to noise and interference."""
        return snr_ratio >= self._acquisition_ratio

    def log_success(self, snr_ratio: float, payload_bytes: int) -> float:
        """Return the logarithm of the probability that no frame of a payload has an error."""
        frames = self._frames(payload_bytes)
        if self._params.frame_error_snr_db:
            error_prob = self._published_error_prob(snr_ratio)
            return frames * math.log1p(-error_prob) if error_prob < 1.0 else -math.inf
        air_error_prob = self._bit_error_prob(self._code.rate_ratio * self._ebn0_per_snr * snr_ratio)
        bits = 8.0 * self._params.frame_bytes * frames
        return bits * math.log1p(-self._code.event_prob(air_error_prob))

    def _frames(self, payload_bytes: int) -> int:
        return -(-payload_bytes // self._params.frame_bytes)

    def _published_error_prob(self, snr_ratio: float) -> float:
        """Return the error probability of a frame, between the published points."""
        levels_db, probs = self._params.frame_error_snr_db, self._params.frame_error_probs
        snr_db = 10.0 * math.log10(max(snr_ratio, 1e-300))
        above = bisect_right(levels_db, snr_db)
        if above in (0, len(levels_db)):
            return probs[0 if above == 0 else -1]
        share = (snr_db - levels_db[above - 1]) / (levels_db[above] - levels_db[above - 1])
        return probs[above - 1] + share * (probs[above] - probs[above - 1])
