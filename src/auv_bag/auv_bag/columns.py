"""
Messages as columns: many messages of one type, read at once.

Messages of one topic have few shapes, mostly one: if texts and sequences have equal lengths, every number
has the same offset. One message of a shape is parsed; NumPy finds the others and reads their numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

from auv_bag.rows import Bytes, MessageRows
from auv_core.cdr import COUNT, ENCAPSULATION, LITTLE_ENDIAN, MOST_END_PADDING, MalformedError, aligned

_BIG_ENDIAN = b"\x00\x00"
_NUMPY_NAMES = {"byte": "int8", "char": "uint8", "bool": "uint8"}
_MOST_SHAPES = 16
"""Number of shapes that are kept for messages of one size."""
_WINDOW = 4096
"""Number of messages that are searched for those of one shape, since each could have its own shape."""


class _Numbers(NamedTuple):
    """Place of a number, or of a sequence of `length` numbers, in a message."""

    at: int
    dtype: np.dtype[Any]
    length: int | None
    is_flag: bool = False

    def of(self, rows: Bytes) -> NDArray[Any]:
        values = self._stored(rows)
        return values != 0 if self.is_flag else values

    def _stored(self, rows: Bytes) -> NDArray[Any]:
        n, size = rows.shape
        if self.length is None:
            return np.ndarray((n,), self.dtype, rows, self.at, (size,))
        return np.ndarray((n, self.length), self.dtype, rows, self.at, (size, self.dtype.itemsize))


class Columns:
    """
    Messages of one shape: the fields of one message, but each number is an array with one for each message.

    A sequence of messages is a list of Columns. Texts and lengths are the same for all messages. Any
    byte but 0 is a set flag.
    """

    def __init__(self, rows: Bytes, fields: dict[str, Any]) -> None:
        self._rows = rows
        self._fields = fields

    def __len__(self) -> int:
        return len(self._rows)

    def __getattr__(self, name: str) -> Any:
        if name not in self._fields:
            raise AttributeError(name)
        return _read(self._rows, self._fields[name])

    def only(self, wanted: NDArray[np.bool_]) -> Columns:
        """Return the messages that the flags select."""
        return Columns(self._rows[wanted], self._fields)


def _read(rows: Bytes, field: Any) -> Any:
    if isinstance(field, _Numbers):
        return field.of(rows)
    if isinstance(field, dict):
        return Columns(rows, field)
    return [_read(rows, each) for each in field] if isinstance(field, list) else field


class Batch(NamedTuple):
    """
    Messages of one topic and one shape.

    Attributes
    ----------
    order : (n, 2) array of uint64
        Log time (ns) of each message and its place in the bag, which orders messages of one time.

    """

    messages: Columns
    order: NDArray[np.uint64]

    def only(self, wanted: NDArray[np.bool_]) -> Batch:
        """Return the messages that the flags select."""
        return Batch(self.messages.only(wanted), self.order[wanted])


class _Shape:
    """Places of all fields in messages of one size with the same lengths and texts."""

    def __init__(self, data: bytes, types: Typestore, type_name: str) -> None:
        walk = _Walk(data, types)
        self.fields = walk.fields(type_name)
        walk.check_end()
        self._fixed_at = np.concatenate([np.arange(start, stop) for start, stop in walk.fixed])
        self._fixed = np.frombuffer(data, np.uint8)[self._fixed_at]

    def is_of(self, rows: Bytes) -> NDArray[np.bool_]:
        """Return which messages have this shape."""
        flags: NDArray[np.bool_] = (rows[:, self._fixed_at] == self._fixed).all(axis=1)
        return flags


class ColumnReader:
    """Reads messages of one type."""

    def __init__(self, types: Typestore, type_name: str) -> None:
        self._types = types
        self._type_name = type_name
        self._shapes: dict[int, list[_Shape]] = {}

    def read(self, rows: MessageRows) -> Iterator[Batch]:
        """Yield messages grouped by shape; malformed ones are left out."""
        data, order = rows.data, rows.order
        shapes = self._shapes.setdefault(data.shape[1], [])
        for start in range(0, len(data), _WINDOW):
            left = np.arange(start, min(start + _WINDOW, len(data)))
            known = iter(tuple(shapes))
            while len(left):
                shape = next(known, None) or self._new_shape(data[left[0]], shapes)
                if shape is None:
                    left = left[1:]
                    continue
                is_of = shape.is_of(data[left])
                if is_of.any():
                    found = left[is_of]
                    yield Batch(Columns(data[found], shape.fields), order[found])
                left = left[~is_of]

    def _new_shape(self, row: Bytes, shapes: list[_Shape]) -> _Shape | None:
        """Return the shape of a message and keep it; None for a malformed message."""
        try:
            shape = _Shape(row.tobytes(), self._types, self._type_name)
        except (ValueError, LookupError, TypeError):  # bytes that do not match the definition
            return None
        shapes.insert(0, shape)
        del shapes[_MOST_SHAPES:]
        return shape


class _Walk:
    """
    A parser for one message.

    Attributes
    ----------
    fixed : list of (start, stop)
        Places of lengths and texts, and of the byte order.

    """

    def __init__(self, data: bytes, types: Typestore) -> None:
        if data[:2] not in (LITTLE_ENDIAN, _BIG_ENDIAN):
            raise MalformedError("no CDR")
        self.fixed = [(0, 2)]
        self._data = data
        self._types = types
        self._order: Literal["<", ">"] = "<" if data.startswith(LITTLE_ENDIAN) else ">"
        self._at = len(ENCAPSULATION)

    def fields(self, type_name: str) -> dict[str, Any]:
        """Return the fields of a message at the current place: their places, or their texts."""
        return {name: self._field(kind) for name, kind in self._types.get_msgdef(type_name).fields}

    def check_end(self) -> None:
        """Raise MalformedError if more than padding follows."""
        if not 0 <= len(self._data) - self._at <= MOST_END_PADDING:
            raise MalformedError("too long")

    def _field(self, kind: Any) -> Any:
        node, what = kind
        if node == Nodetype.NAME:
            return self.fields(what)
        if node == Nodetype.BASE:
            return self._text() if what[0] == "string" else self._numbers(what[0], None)
        (element_node, element), count = what
        if node == Nodetype.SEQUENCE:
            count = self._length()
        if element_node == Nodetype.BASE and element[0] != "string":
            return self._numbers(element[0], count)
        return [self._field(what[0]) for _ in range(count)]

    def _numbers(self, name: str, count: int | None) -> _Numbers:
        dtype = np.dtype(_NUMPY_NAMES.get(name, name)).newbyteorder(self._order)
        if count != 0:
            self._at = aligned(self._at, dtype.itemsize)
        numbers = _Numbers(self._at, dtype, count, name == "bool")
        self._pass(dtype.itemsize * (1 if count is None else count))
        return numbers

    def _text(self) -> str:
        length = self._length()
        start = self._at
        self._pass(length)
        self.fixed.append((start, self._at))
        data = self._data[start : self._at]
        if not data.endswith(b"\0"):
            raise MalformedError("a text has no end")
        return data[:-1].decode()

    def _length(self) -> int:
        start = self._at = aligned(self._at, COUNT.size)
        self._pass(COUNT.size)
        self.fixed.append((start, self._at))
        return int.from_bytes(self._data[start : self._at], "little" if self._order == "<" else "big")

    def _pass(self, size: int) -> None:
        self._at += size
        if self._at > len(self._data):
            raise MalformedError("too short")
