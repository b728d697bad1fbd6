"""Diagnostics as a serialised ROS message, written as bytes for the reason given in `acoustic_bytes`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.cdr import COUNT, align, begun, put_text


@dataclass(frozen=True, slots=True)
class Status:
    """
    Status of a part of a node: diagnostic_msgs/DiagnosticStatus.

    `level` is one of that message's constants, `values` are (key, value).
    """

    level: bytes
    name: str
    message: str
    hardware_id: str
    values: Sequence[tuple[str, str]] = ()


def diagnostics_bytes(statuses: Sequence[Status], t_s: float) -> bytes:
    """Return diagnostic_msgs/DiagnosticArray at the time `t_s` (s)."""
    out = begun("", t_s)
    out += COUNT.pack(len(statuses))
    for status in statuses:
        out += status.level
        for text in (status.name, status.message, status.hardware_id):
            put_text(out, text)
        align(out, COUNT.size)
        out += COUNT.pack(len(status.values))
        for key, value in status.values:
            put_text(out, key)
            put_text(out, value)
    return bytes(out)
