"""
The MCAP file of a bag that is being written: it has no buffer, and its end may be provisional.

A chunk is written when it is full, and the chunk boundaries depend on the messages alone. Messages that are
not in a chunk yet are written after the last chunk, as a provisional chunk that the next one replaces. So a
bag whose writer is killed lacks few messages, and the content of a closed bag does not depend on when it was
saved.
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
    A new file; every write reaches the operating system before it returns.

    A lock (flock) shows others that it is still being written; it always ends with this process.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("xb", buffering=0)
        with suppress(OSError):  # a file system without locks
            lock_file(self._file.fileno())
        self._position = 0
        self._has_tail = False

    def write(self, data: bytes) -> int:
        """Append bytes; replace the tail if there is one."""
        self._drop_tail()
        self._position += self._append(data)
        return len(data)

    def put_tail(self, data: bytes) -> None:
        """Write bytes after the end until the next write; they do not count in `tell`."""
        self._drop_tail()
        self._has_tail = True
        self._append(data)

    def tell(self) -> int:
        """Return the size of the file without the tail (bytes)."""
        return self._position

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

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
    Return messages as one self-contained chunk with its index.

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
