"""
Zeroes the padding of serialised messages, and removes the padding at their end.

CDR aligns numbers to their size. The skipped bytes have no meaning, and the middleware leaves old content of
its buffer there. So two equal messages can differ in these bytes and in the padding at their end. Bags that
must be equal to the byte need zeros in the gaps and no padding at the end.

Alignment counts from the end of the 4-byte encapsulation header; numbers of 8 bytes align to 8 (plain CDR,
XCDR1).
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from auv_bag.definitions import SEPARATOR, MessageType
from auv_core.cdr import COUNT, ENCAPSULATION, LITTLE_ENDIAN, aligned

_HEADER_BYTES = len(ENCAPSULATION)
_SIZES = {"bool": 1, "byte": 1, "char": 1, "float32": 4, "float64": 8} | {
    f"{sign}int{bits}": bits // 8 for sign in ("", "u") for bits in (8, 16, 32, 64)
}
_FIELD = re.compile(r"\s*([\w/]+(?:<=\d+)?)(\[[^\]]*\])?\s+[a-zA-Z]\w*\s*(=?)")
_BUILTIN_PACKAGES = {
    "Header": "std_msgs/Header",
    "Time": "builtin_interfaces/Time",
    "Duration": "builtin_interfaces/Duration",
}


@dataclass(frozen=True)
class _Numbers:
    """`count` numbers of `size` bytes, one after the other."""

    size: int
    count: int


@dataclass(frozen=True)
class _Text:
    """A string: its length, its characters, a NUL."""


@dataclass(frozen=True)
class _List:
    """A sequence: its length, then that many times the steps."""

    steps: tuple[_Step, ...]


_Step = _Numbers | _Text | _List


class _Shape:
    """
    Places of padding in all messages with these lengths of strings and sequences.

    Messages of one topic have few shapes, mostly one: a message is compared with the last shape of its size
    before it is parsed.
    """

    def __init__(self, data: bytes, lengths: Sequence[slice], padding: Sequence[slice], end: int) -> None:
        self.read_lengths = _reader(lengths, len(data))
        self.lengths = self.read_lengths(data)
        self.read_padding = _reader(padding, len(data))
        self.no_padding = tuple(bytes(gap.stop - gap.start) for gap in padding)
        self.padding = padding
        self.end = end

    def cleared(self, data: bytes) -> bytes:
        """Return a message of this shape with zeros in its padding."""
        clean = bytearray(data)
        for gap, zeros in zip(self.padding, self.no_padding, strict=True):
            clean[gap] = zeros
        return bytes(clean)


def _reader(places: Sequence[slice], size: int) -> Callable[[bytes], tuple[bytes, ...]]:
    """Return the function that extracts the bytes at ascending places from messages of one size."""
    layout, position = "", 0
    for place in places:
        layout += f"{place.start - position}x{place.stop - place.start}s"
        position = place.stop
    return struct.Struct(f"{layout}{size - position}x").unpack


def padding_zeroer(message_type: MessageType) -> Callable[[bytes], bytes | None]:
    """
    Return the function that zeroes the padding of messages of one type and removes the padding at their end.

    The network pads messages to multiples of four bytes, delivery inside a process does not. The function
    never changes other bytes; for bytes that do not match the definition it returns None.
    """
    steps = _steps(message_type)
    shapes: dict[int, _Shape] = {}

    def zeroed(data: bytes) -> bytes | None:
        size = len(data)
        shape = shapes.get(size)
        if shape is None or shape.read_lengths(data) != shape.lengths:
            shape = _shape_of(data, steps)
            if shape is None:
                return None
            shapes[size] = shape
        if shape.read_padding(data) != shape.no_padding:
            data = shape.cleared(data)
        return data if shape.end == size else data[: shape.end]

    return zeroed


def _shape_of(data: bytes, steps: Sequence[_Step]) -> _Shape | None:
    """Return the shape of a message, or None for bytes that do not match the definition."""
    if data[:2] != LITTLE_ENDIAN:
        return None
    try:
        shape = _Walk(data).shape(steps)
    except (struct.error, IndexError):
        return None
    return shape if 0 <= len(data) - shape.end < _HEADER_BYTES else None


class _Walk:
    """A parser for one message that notes its lengths and its padding."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._lengths = [slice(0, len(LITTLE_ENDIAN))]
        self._padding: list[slice] = []

    def shape(self, steps: Sequence[_Step]) -> _Shape:
        """Return the shape of the message."""
        end = self._walk(_HEADER_BYTES, steps)
        return _Shape(self._data, self._lengths, self._padding, end)

    def _walk(self, position: int, steps: Sequence[_Step]) -> int:
        """Note the padding before every step from `position` on; return the position after the last one."""
        for step in steps:
            if type(step) is _Numbers:
                position = self._aligned(position, step.size) + step.size * step.count
                continue
            position = self._aligned(position, 4)
            (length,) = COUNT.unpack_from(self._data, position)
            self._lengths.append(slice(position, position + 4))
            position += 4
            if type(step) is _Text:
                position += length
            elif type(step) is _List:
                position = self._walk_list(position, step.steps, length)
            if position > len(self._data):
                raise IndexError(position)
        return position

    def _walk_list(self, position: int, steps: tuple[_Step, ...], length: int) -> int:
        only = steps[0]
        if len(steps) == 1 and type(only) is _Numbers:
            return (
                self._aligned(position, only.size) + only.size * only.count * length if length else position
            )
        for _ in range(length):
            position = self._walk(position, steps)
            if position > len(self._data):  # a length may be any number
                raise IndexError(position)
        return position

    def _aligned(self, position: int, size: int) -> int:
        end = aligned(position, size)
        if end > position:
            if end > len(self._data):
                raise IndexError(end)
            self._padding.append(slice(position, end))
        return end


def _steps(message_type: MessageType) -> tuple[_Step, ...]:
    """Return the layout of a type from its full definition."""
    root, *blocks = message_type.definition.split(SEPARATOR + "\n")
    package, _, name = message_type.name.split("/")
    texts = {f"{package}/{name}": root}
    for block in blocks:
        title, _, text = block.partition("\n")
        texts[title.removeprefix("MSG: ").strip().replace("/msg/", "/")] = text
    return _layout(f"{package}/{name}", texts)


def _layout(name: str, texts: dict[str, str]) -> tuple[_Step, ...]:
    steps: list[_Step] = []
    for line in texts[name].splitlines():
        field = _FIELD.match(line.partition("#")[0])
        if field and not field[3]:
            for step in _field_steps(field[1].partition("<=")[0], field[2] or "", name, texts):
                _append(steps, step)
    return tuple(steps) or (_Numbers(1, 1),)


def _field_steps(kind: str, array: str, name: str, texts: dict[str, str]) -> tuple[_Step, ...]:
    if kind in _SIZES:
        one: tuple[_Step, ...] = (_Numbers(_SIZES[kind], 1),)
    elif kind == "string":
        one = (_Text(),)
    else:
        full = (
            _BUILTIN_PACKAGES.get(kind, kind)
            if "/" not in kind and f"{name.split('/')[0]}/{kind}" not in texts
            else kind
        )
        full = full.replace("/msg/", "/") if "/" in full else f"{name.split('/')[0]}/{full}"
        one = _layout(full, texts)
    if not array:
        return one
    count = array.strip("[]")
    if not count or count.startswith("<="):
        return (_List(one),)
    if len(one) == 1 and isinstance(one[0], _Numbers):
        return (_Numbers(one[0].size, one[0].count * int(count)),)
    return one * int(count)


def _append(steps: list[_Step], step: _Step) -> None:
    """Add a step; merge it with the one before if both are numbers of one size."""
    before = steps[-1] if steps else None
    if isinstance(step, _Numbers) and isinstance(before, _Numbers) and before.size == step.size:
        steps[-1] = _Numbers(step.size, before.count + step.count)
    else:
        steps.append(step)
