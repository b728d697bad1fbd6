"""
Modems: airtime, reception and size of a packet.

To add one, write one file with ``Params`` and ``Modem(params)``, an `AcousticModem`: it recognises every
signal in range and has no bit errors. A modem with sound levels is a `LevelModem`.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.params import Section


class AcousticModem(Protocol):
    """
    One kind of modem.

    Attributes
    ----------
    max_payload_bytes : int
        Largest payload.
    preamble_s : float
        The part of the airtime before the first bit (s).
    max_range_m : float
        Range beyond which there is no signal at all (m; inf for none).
    captures : bool
        Whether a receiver that has locked on to a packet keeps it when another one comes, or loses both to
        any overlap with a signal that it could have acquired.

    """

    max_payload_bytes: int
    preamble_s: float
    max_range_m: float
    captures: bool

    def airtime_s(self, payload_bytes: int) -> float:
        """Return how long a packet is on the air (s)."""


@runtime_checkable
class LevelModem(AcousticModem, Protocol):
    """A modem with sound levels; `frequency_khz` is its carrier, for the transmission loss (kHz)."""

    frequency_khz: float

    def snr_ratio(self, loss_db: float) -> float:
        """Return signal to ambient noise in the band, as a ratio of powers, after a loss (dB)."""

    def acquires(self, snr_ratio: float) -> bool:
        """Return whether the start of a packet is recognised, for a ratio to noise and interference."""

    def log_success(self, snr_ratio: float, payload_bytes: int) -> float:
        """
        Return the logarithm of the probability that a packet has no error, from minus infinity to 0.

        The ratio is the same one, and lasts for the whole packet.
        """


def make_modem(section: Section) -> AcousticModem:
    """Return the modem of a section."""
    modem: AcousticModem = fulfilled(class_of(__name__, section.kind, "Modem")(section.params), AcousticModem)
    return modem
