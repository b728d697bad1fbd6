"""
Numbers in few bits: bounded fields with a resolution, packed without gaps.

A `Field` defines the possible values of a number: multiples of a resolution between two bounds, or, if it
`wraps`, multiples modulo its range. This determines its number of bits, and the error of a round trip: at
most half a resolution inside the bounds. A `RatioField` has zero and values with a constant ratio instead.
Values outside saturate at the bound and are counted. NaN, and infinity if a field wraps, are refused. A
`Reserved` field has no value yet: its bits are zero. A `Layout` is a sequence of these, the first in the most
significant bits of the first byte; the last byte is padded with zeros.

The idea is that of the Dynamic Compact Control Language (Schneider & Schmidt, "The Dynamic Compact Control
Language: A compact marshalling scheme for acoustic communications", OCEANS 2010), without its compiler: the
description is data in the program.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from auv_flocking.report import ReportError

_MOST_STEPS = 2**40


class Levels(Protocol):
    """The possible values of one number, which are numbered from 0, its name, and its number of bits."""

    @property
    def name(self) -> str:
        """Its name, unique in a layout; with the unit as suffix."""

    @property
    def bits(self) -> int:
        """Number of bits."""

    @property
    def levels(self) -> int:
        """Number of possible values."""

    def level(self, value: float) -> int:
        """Return the number of the level nearest to a value; outside 0 .. `levels` - 1: out of bounds."""

    def value(self, level: int) -> float:
        """Return the value of a level."""

    def row(self) -> tuple[str, ...]:
        """Return smallest and largest value, resolution and largest error inside, for a table."""


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

    def row(self) -> tuple[str, ...]:
        """Return smallest and largest value, resolution and largest error inside, for a table."""
        largest = f"wraps at {self.maximum:g}" if self.wraps else f"{self.maximum:g}"
        error = "whole numbers" if isinstance(self.resolution, int) else f"{0.5 * self.resolution:g}"
        return f"{self.minimum:g}", largest, f"{self.resolution:g}", error


@dataclass(frozen=True, slots=True)
class RatioField:
    """
    Zero, and values with a constant ratio: the relative error is the same for small and large values.

    A value above zero never becomes zero.

    Parameters
    ----------
    name : str
        Its name, unique in a layout; with the unit as suffix.
    smallest : float
        Smallest value above zero.
    steps_per_octave : int
        Number of values from one value to its double.
    bits : int
        Number of bits.

    """

    name: str
    smallest: float
    steps_per_octave: int
    bits: int
    levels: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "levels", 1 << self.bits)

    @property
    def largest(self) -> float:
        """Largest value."""
        return self.value(self.levels - 1)

    def level(self, value: float) -> int:
        """
        Return the number of the level nearest to `value` by ratio; 0 is the level of zero.

        Raises
        ------
        ReportError
            For NaN.

        """
        if math.isnan(value):
            raise ReportError(f"{self.name}: {value} cannot be sent")
        if value <= 0.0:
            return 0 if value == 0.0 else -1
        if math.isinf(value):
            return self.levels
        return max(1, 1 + round(self.steps_per_octave * math.log2(value / self.smallest)))

    def value(self, level: int) -> float:
        """Return the value of a level."""
        return 0.0 if level == 0 else self.smallest * 2.0 ** ((level - 1) / self.steps_per_octave)

    def row(self) -> tuple[str, ...]:
        """Return smallest and largest value, resolution and largest error inside, for a table."""
        step = 2.0 ** (1.0 / self.steps_per_octave)
        half = 100.0 * (math.sqrt(step) - 1.0)
        return f"0, then {self.smallest:g}", f"{self.largest:.4g}", f"x {step:.4f}", f"{half:.1f} %"


@dataclass(frozen=True, slots=True)
class Reserved:
    """Bits without a meaning so far, which are zero; `name` says for what they are kept."""

    name: str
    bits: int
    levels: int = field(default=1, init=False, repr=False)

    def level(self, value: float) -> int:
        """Return 0, the only level."""
        return 0

    def value(self, level: int) -> float:
        """Return zero."""
        return 0.0

    def row(self) -> tuple[str, ...]:
        """Return the row of a table: reserved, zero."""
        return "reserved", "0", "", ""


class Layout:
    """
    A sequence of fields, and the number of values that have saturated so far.

    Parameters
    ----------
    fields : sequence of Field, RatioField or Reserved
        In the order of their bits.

    """

    def __init__(self, fields: Sequence[Levels]) -> None:
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
            (item, item.bits, (1 << item.bits) - 1, item.levels) for item in reversed(self.fields)
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
        for item, bits, mask, levels in self._from_last:
            level = word & mask
            if level >= levels:
                raise ReportError(f"{item.name}: {level} stands for no value")
            values.append(item.value(level))
            word >>= bits
        values.reverse()
        return values


def steps_around_zero(name: str, step: float, half: int) -> Field:
    """Return a field of -half .. half - 1 steps."""
    return Field(name, -half * step, (half - 1) * step, step)


def field_table(fields: Sequence[Levels]) -> list[str]:
    """Return the lines of a Markdown table of fields: bits, bounds, resolution, largest error inside."""
    rows = [(f"`{item.name}`", str(item.bits), *item.row()) for item in fields]
    lines = [
        "| field | bits | smallest | largest | resolution | error inside |",
        "|---|---|---|---|---|---|",
    ]
    return lines + [f"| {' | '.join(row)} |" for row in rows]
