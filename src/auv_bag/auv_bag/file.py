"""
The MCAP file of a bag that is being written: nothing is held back, and its end may be provisional.

A chunk goes to the file when it is full, and where chunks end depends on the messages alone. What is not in a
chunk yet stands behind the last one, as a chunk that the next real one replaces. So a bag whose writer is
killed lacks little, and one that is closed does not tell when its writer was asked to save.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from mcap.writer import CompressionType, Writer

from auv_core.machine.file_locks import lock_file


class TimedMessage(NamedTuple):
    """A serialised message with its channel and its log and publish time (ns)."""

    time_ns: int
    channel: int
    data: bytes


class BagFile:
    """
    A new file whose every write reaches the operating system before it returns.

    A lock (flock) tells others that it is still being written; it ends with this process, however that ends.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("xb", buffering=0)
        with suppress(OSError):  # a file system without locks
            lock_file(self._file.fileno())
        self._position = 0
        self._has_tail = False

    def write(self, data: bytes) -> int:
        """Append bytes, in the place of the tail where there is one."""
        self._drop_tail()
        self._position += self._append(data)
        return len(data)

    def put_tail(self, data: bytes) -> None:
        """Put bytes behind the end until the next write; they do not count in `tell`."""
        self._drop_tail()
        self._has_tail = True
        self._append(data)

    def tell(self) -> int:
        """Return how many bytes are in the file, without the tail."""
        return self._position

    def flush(self) -> None:
        """Do nothing: nothing is held back."""

    def close(self) -> None:
        """Close the file; a tail stays."""
        self._file.close()

    def _drop_tail(self) -> None:
        if self._has_tail:
            self._file.truncate(self._position)
            self._file.seek(self._position)
            self._has_tail = False

    def _append(self, data: bytes) -> int:
        view = memoryview(data)
        while view:
            view = view[self._file.write(view) :]
        return len(data)


def chunk_of(messages: Sequence[TimedMessage], register: Callable[[Writer], None]) -> bytes:
    """
    Return messages as one chunk, with its index, that can be read by itself.

    Parameters
    ----------
    messages
        In the order in which they are written.
    register
        Registers the channels of the bag, all of them, in the order of their numbers.
    """
    stream = BytesIO()
    writer = Writer(stream, chunk_size=2**62, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="shoal")
    register(writer)
    start = stream.tell()
    for each in messages:
        writer.add_message(each.channel, each.time_ns, each.data, each.time_ns)
    writer.flush()
    return stream.getvalue()[start:]
