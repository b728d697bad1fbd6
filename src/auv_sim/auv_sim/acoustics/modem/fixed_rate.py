"""
A modem with one bit rate and a maximum range.

It models no sound levels. Within its range every packet is received without errors, unless two overlap at
the receiver: then both are lost, or with `capture` only the second one.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.modem import AcousticModem


@dataclass(frozen=True)
class Params:
    """Rate, overhead and range."""

    bit_rate_bps: float = param("bits per second on the air", default=5000.0, above=0.0)
    preamble_s: float = param("time on the air before the first bit (s)", default=0.0, minimum=0.0)
    max_payload_bytes: int = param("largest payload (bytes)", default=128, minimum=1, maximum=65535)
    max_range_m: float = param("range beyond which a packet is lost (m)", default=1000.0, above=0.0)
    capture: bool = param(
        "whether a receiver keeps the packet that it is receiving when another one comes", default=False
    )


class Modem(AcousticModem):
    """Airtime is the preamble plus the payload's bits over the rate."""

    def __init__(self, params: Params) -> None:
        self._params = params
        self.max_range_m = params.max_range_m
        self.max_payload_bytes = params.max_payload_bytes
        self.preamble_s = params.preamble_s
        self.captures = params.capture

    def airtime_s(self, payload_bytes: int) -> float:
        """Return the time on the air (s) of a payload."""
        return self._params.preamble_s + 8.0 * payload_bytes / self._params.bit_rate_bps
