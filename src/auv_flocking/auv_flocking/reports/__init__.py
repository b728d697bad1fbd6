"""
Formats of the report: its size, and the rounding errors of its numbers.

To add one, write one file with ``Params`` and ``Format(params, shared)``, a `ReportFormat`, where `shared`
is the sequence of `auv_flocking.codec.Field` that the consensus filter adds to every report.  The file's
name is its ``kind``.

Every payload begins with its version in the four highest bits of the first byte.  `VERSIONS` is the list of
all versions: each belongs to one kind, so that formats cannot be confused, and is never used again.  A kind
also reads its older versions, so that old recordings stay readable.  Vehicles with different tasks may use
different formats (`auv_flocking.report_reader`); those of one kind use it alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Box
from auv_core.params import Section
from auv_flocking.codec import Field
from auv_flocking.heard import BITS, CODES
from auv_flocking.report import Report, ReportError


class Versions(NamedTuple):
    """The version that a kind writes, and the older ones that it reads, too."""

    written: int
    older: tuple[int, ...] = ()


VERSIONS = {
    "compact": Versions(4, older=(3,)),
    "exact": Versions(5, older=(0,)),
    "lane": Versions(6),
}


def version_in(payload: bytes, kind: str) -> int:
    """
    Return the version of a payload; for an empty one, that which the kind writes.

    Raises
    ------
    ReportError
        For a version that this kind does not read.

    """
    written, older = VERSIONS[kind]
    version = payload[0] >> 4 if payload else written
    if version != written and version not in older:
        read = " and ".join(map(str, sorted((written, *older))))
        raise ReportError(f"version {version}; this format reads {read}")
    return version


def whole_numbers(report: Report) -> tuple[int, int, int, int]:
    """
    Return `is_bounded`, `is_holding`, `heard_code` and `heard_mask` for sending.

    Raises
    ------
    ReportError
        For numbers that the report lacks, or that cannot be.

    """
    numbers = report.is_bounded, report.is_holding, report.heard_code, report.heard_mask
    known = tuple([-1 if number is None else int(number) for number in numbers])
    if not all(0 <= number < end for number, end in zip(known, (2, 2, CODES, 1 << BITS), strict=True)):
        raise ReportError(f"is_bounded, is_holding, heard_code, heard_mask: {numbers} cannot be sent")
    return known[0], known[1], known[2], known[3]


class Bounds(NamedTuple):
    """
    What a format carries without saturating.

    The sender's position (m; NED), a velocity along north and east and one along down (m/s), and along each
    axis the distance of the flocking centre from the sender (m).
    """

    position: Box
    velocity_mps: float
    descent_mps: float
    centre_distance_m: float


class ReportDecoder(Protocol):
    """
    Converts bytes to reports.

    Attributes
    ----------
    position_resolution_m, velocity_resolution_mps : float
        Steps of the sender's position and velocity (0 if negligible), so that a filter can add the rounding
        error to its noise.

    """

    position_resolution_m: float
    velocity_resolution_mps: float

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report; `now_s` (s) selects the time of a wrapped time tag.

        Raises
        ------
        ReportError
            The only exception, for any bytes that are not a report of this format: another length, another
            version, address 0, undefined bits.

        """


class ReportFormat(ReportDecoder, Protocol):
    """
    Converts reports to bytes and back.

    Attributes
    ----------
    payload_bytes : int
        Size of every payload (bytes).
    budget : sequence of (str, int)
        Name and number of bits of every field, in their order.
    carries : Bounds
        Limits without saturation: a scenario that exceeds them is refused, and a vehicle of a fleet whose
        position exceeds them holds.

    """

    payload_bytes: int
    budget: Sequence[tuple[str, int]]
    carries: Bounds

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


def make_format(section: Section, shared_fields: Sequence[Field] = ()) -> ReportFormat:
    """Return the format of a section, with the fields that the consensus filter adds."""
    made = class_of(__name__, section.kind, "Format")(section.params, shared_fields)
    report_format: ReportFormat = fulfilled(made, ReportFormat)
    return report_format
