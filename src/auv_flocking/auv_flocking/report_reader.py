"""Reads the reports of vehicles that use several formats: the version of a payload names its format."""

from __future__ import annotations

from collections.abc import Mapping

from auv_flocking.report import Report, ReportError
from auv_flocking.reports import VERSIONS, ReportDecoder, ReportFormat


class ReportReader(ReportDecoder):
    """
    Decodes the reports of several formats.

    Parameters
    ----------
    formats : mapping
        The formats of a fleet by their kind; one of each kind, since a version does not tell two of a kind
        apart.

    Resolutions are those of the coarsest format, so that a filter does not trust one too much.

    """

    def __init__(self, formats: Mapping[str, ReportFormat]) -> None:
        self._by_version = {
            version: made
            for kind, made in formats.items()
            for version in (VERSIONS[kind].written, *VERSIONS[kind].older)
        }
        self.position_resolution_m = max(made.position_resolution_m for made in formats.values())
        self.velocity_resolution_mps = max(made.velocity_resolution_mps for made in formats.values())

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report; `now_s` (s) selects the time of a wrapped time tag.

        Raises
        ------
        ReportError
            For bytes that are no report of any of the formats.

        """
        if not payload:
            raise ReportError("a report of no bytes")
        made = self._by_version.get(payload[0] >> 4)
        if made is None:
            *others, last = map(str, sorted(self._by_version))
            read = f"{', '.join(others)} and {last}"
            raise ReportError(f"version {payload[0] >> 4}; the formats of this fleet read {read}")
        return made.decode(payload, now_s)
