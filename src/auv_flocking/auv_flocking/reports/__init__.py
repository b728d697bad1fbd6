"""
Formats of the report: its size, and the rounding errors of its numbers.

To add one, write one file with ``Params`` and ``Format(params, shared)``, a `ReportFormat`, where `shared`
is the sequence of `auv_flocking.codec.Field` that the consensus filter adds to every report.  The file's
name is its ``kind``.

Every format begins with its version in the four lowest (`exact`) or highest (`compact`) bits of the first
byte and has a different length, so that formats cannot be confused.  A flock's vehicles use one format.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Box
from auv_core.params import Section
from auv_flocking.codec import Field
from auv_flocking.report import Report


class Bounds(NamedTuple):
    """
    What a format carries without saturating.

    The sender's position (m; NED), a velocity along each axis (m/s), and along each axis the distance of the
    flocking centre from the sender (m).
    """

    position: Box
    velocity_mps: float
    centre_distance_m: float


class ReportFormat(Protocol):
    """
    Converts reports to bytes and back.

    Attributes
    ----------
    payload_bytes : int
        Size of every payload (bytes).
    carries : Bounds
        Limits without saturation: a scenario that exceeds them is refused, and a vehicle of a fleet whose
        position exceeds them holds.
    position_resolution_m, velocity_resolution_mps : float
        Steps of the sender's position and velocity (0 if negligible), so that a filter can add the rounding
        error to its noise.

    """

    payload_bytes: int
    carries: Bounds
    position_resolution_m: float
    velocity_resolution_mps: float

    @property
    def saturated(self) -> int:
        """Number of values that were limited so far."""

    def encode(self, report: Report) -> bytes:
        """
        Return the payload; values out of bounds saturate.

        Raises
        ------
        ReportError
            For numbers that cannot be sent (NaN).

        """

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report; `now_s` (s) selects the time of a wrapped time tag.

        Raises
        ------
        ReportError
            The only exception, for any bytes that are not a report of this format: another length, another
            version, address 0, undefined bits.

        """


def make_format(section: Section, shared_fields: Sequence[Field] = ()) -> ReportFormat:
    """Return the format of a section, with the fields that the consensus filter adds."""
    made = class_of(__name__, section.kind, "Format")(section.params, shared_fields)
    report_format: ReportFormat = fulfilled(made, ReportFormat)
    return report_format
