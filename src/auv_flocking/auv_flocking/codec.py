"""
Numbers in few bits: bounded fields with a resolution, packed without gaps.

A `Field` defines the possible values of a number: multiples of a resolution between two bounds, or, if it
`wraps`, multiples modulo its range. This determines its number of bits, and the error of a round trip: at
most half a resolution inside the bounds. Values outside saturate at the bound and are counted. NaN, and
infinity if a field wraps, are refused. A `Layout` is a sequence of fields, the first in the most significant
bits of the first byte; the last byte is padded with zeros.

The idea is that of the Dynamic Compact Control Language (Schneider & Schmidt, "The Dynamic Compact Control
Language: A compact marshalling scheme for acoustic communications", OCEANS 2010), without its compiler: the
description is data in the program.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from auv_flocking.report import ReportError

_MOST_STEPS = 2**40


@dataclass(frozen=True, slots=True)
class Field:
    """
    The possible values of one number.

    Parameters
    ----------
    name : str
        Its name, unique in a layout; with the unit as suffix.
    minimum, maximum : float
        Smallest and largest value; if the field `wraps`, `maximum` is the first value that is decoded as
        `minimum` again.
    resolution : float
        Step between neighbouring values. The bounds are whole multiples of it, so that zero stays zero. If
        the resolution is a power of two, values are exact in floating point.
    wraps : bool
        Whether values are taken modulo the range.

    """

    name: str
    minimum: float
    maximum: float
    resolution: float
    wraps: bool = False
    levels: int = field(init=False, repr=False)
    bits: int = field(init=False, repr=False)
    lowest: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        numbers = (self.minimum, self.maximum, self.resolution)
        if not all(map(math.isfinite, numbers)) or self.resolution <= 0.0 or self.maximum <= self.minimum:
            raise ValueError(
                f"{self.name}: bounds {self.minimum!r} to {self.maximum!r} with resolution "
                f"{self.resolution!r} are not allowed; allowed: finite, maximum above minimum, resolution "
                "above 0"
            )
        first, last = self.minimum / self.resolution, self.maximum / self.resolution
        lowest = round(first)
        levels = round(last) - lowest + (0 if self.wraps else 1)
        rest = max(abs(first - round(first)), abs(last - round(last)))
        if rest > 1e-3 or levels < 2 or max(abs(first), abs(last)) > _MOST_STEPS:
            raise ValueError(
                f"{self.name}: bounds {self.minimum!r} to {self.maximum!r} with resolution "
                f"{self.resolution!r} are not allowed; allowed: bounds that are multiples of the resolution, "
                "at least one and at most 2^40 of them"
            )
        object.__setattr__(self, "lowest", lowest)
        object.__setattr__(self, "levels", levels)
        object.__setattr__(self, "bits", (levels - 1).bit_length())

    def level(self, value: float) -> int:
        """
        Return the number of the level nearest to `value`, counted from the minimum; outside 0 .. `levels` -
        1 it is out of bounds.

        Raises
        ------
        ReportError
            For NaN, and for infinity if the field wraps.

        """
        steps = value / self.resolution
        if math.isfinite(steps):
            level = round(steps) - self.lowest
            return level % self.levels if self.wraps else level
        if math.isnan(steps) or self.wraps:
            raise ReportError(f"{self.name}: {value} cannot be sent")
        return -1 if steps < 0.0 else self.levels

    def value(self, level: int) -> float:
        """Return the value of a level."""
        return (level + self.lowest) * self.resolution

    def rounded(self, value: float) -> float:
        """Return `value` after a round trip."""
        return self.value(min(max(self.level(value), 0), self.levels - 1))


class Layout:
    """
    A sequence of fields, and the number of values that have saturated so far.

    Parameters
    ----------
    fields : sequence of Field
        In the order of their bits.

    """

    def __init__(self, fields: Sequence[Field]) -> None:
        names = [item.name for item in fields]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"fields: {twice[0]!r} twice is not allowed; allowed: one field of each name")
        self.fields = tuple(fields)
        self.bits = sum(item.bits for item in fields)
        self.payload_bytes = (self.bits + 7) // 8
        self.saturated = 0
        self._padding = 8 * self.payload_bytes - self.bits
        self._from_last = [
            (item, item.bits, (1 << item.bits) - 1, item.levels, item.lowest, item.resolution)
            for item in reversed(self.fields)
        ]

    def pack(self, values: Sequence[float]) -> bytes:
        """
        Return the bytes of one value per field.

        Raises
        ------
        ReportError
            For a value that is NaN.
        ValueError
            For a wrong number of values.

        """
        word = 0
        for item, value in zip(self.fields, values, strict=True):
            level = item.level(value)
            if level < 0:
                level = 0
                self.saturated += 1
            elif level >= item.levels:
                level = item.levels - 1
                self.saturated += 1
            word = word << item.bits | level
        return (word << self._padding).to_bytes(self.payload_bytes, "big")

    def unpack(self, payload: bytes) -> list[float]:
        """
        Return the values in `payload`.

        Raises
        ------
        ReportError
            For a wrong length, for bits without a value, and for padding that is not zero.

        """
        if len(payload) != self.payload_bytes:
            raise ReportError(f"a report has {self.payload_bytes} bytes, this has {len(payload)}")
        word = int.from_bytes(payload, "big")
        if word & ((1 << self._padding) - 1):
            raise ReportError("the padding at the end of a report is not zero")
        word >>= self._padding
        values = []
        for item, bits, mask, levels, lowest, resolution in self._from_last:
            level = word & mask
            if level >= levels:
                raise ReportError(f"{item.name}: {level} stands for no value")
            values.append((level + lowest) * resolution)
            word >>= bits
        values.reverse()
        return values


def field_table(fields: Sequence[Field]) -> list[str]:
    """Return the lines of a Markdown table of fields: bits, bounds, resolution, largest error inside."""
    lines = [
        "| field | bits | smallest | largest | resolution | error inside |",
        "|---|---|---|---|---|---|",
    ]
    for item in fields:
        largest = f"wraps at {item.maximum:g}" if item.wraps else f"{item.maximum:g}"
        error = "whole numbers" if isinstance(item.resolution, int) else f"{0.5 * item.resolution:g}"
        lines.append(
            f"| `{item.name}` | {item.bits} | {item.minimum:g} | {largest} | {item.resolution:g} | {error} |"
        )
    return lines
