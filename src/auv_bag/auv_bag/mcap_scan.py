"""Read the messages of an MCAP file in time order, finished or not, without holding it in memory.

The file is read record by record and not through its summary, so that a file whose writer was killed (no
summary, perhaps half a chunk at its end) can be read like any other, up to its end.
"""

from __future__ import annotations

import mmap
import struct
from array import array
from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Schema
from mcap.stream_reader import get_chunk_data_stream

from auv_bag.writer import BagError

MAGIC = b"\x89MCAP0\r\n"
RECORD_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHANNEL_ID = struct.Struct("<H")
_TIME_SPAN = struct.Struct("<QQ")
_NEVER_NS = 2**64
_TAKEN = frozenset({Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.CHUNK, Opcode.MESSAGE})
"""Records outside chunks that are used; a chunk is followed by an index for each of its channels."""
MOST_CHUNK_BYTES = 1_000_000_000


class ScannedMessage(NamedTuple):
    """One message of the file."""

    time_ns: int
    channel: Channel
    data: bytes


@dataclass(frozen=True)
class _Block:
    """
    A chunk, or one message outside any chunk: consecutive messages with their span of log time. For a chunk
    without messages the span begins after all others.
    """

    opcode: int
    start: int
    stop: int
    first_ns: int
    last_ns: int


@dataclass
class McapScan:
    """One opened MCAP file.

    Attributes
    ----------
    complete
        The file has its footer: its writer finished.
    channels
        Channels by id that were found so far; all of them once :meth:`find_channels` has run.
    schemas
        Schemas by id, found likewise.
    """

    path: Path
    complete: bool = False
    channels: dict[int, Channel] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    _blocks: list[_Block] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Map the file and note the positions of its chunks."""
        try:
            with self.path.open("rb") as file:
                self._bytes = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise BagError(f"cannot read {self.path}: {error.strerror}") from None
        except ValueError:
            raise BagError(f"{self.path} is empty") from None
        if self._bytes[: len(MAGIC)] != MAGIC:
            raise BagError(f"{self.path} is not an MCAP file")
        self._walk()

    def find_channels(self) -> None:
        """
        Find every channel: a finished file repeats them at its end, an unfinished one is read completely.
        """
        if self.complete and self.channels:
            return
        for block in self._blocks:
            self.messages_of(block, frozenset())

    def blocks(self) -> Sequence[_Block]:
        """Return the blocks in the order of the file."""
        return self._blocks

    def messages_of(self, block: _Block, topics: Collection[str] | None) -> list[ScannedMessage]:
        """Return the messages of one block in the order of the file, and note its channels.

        Parameters
        ----------
        block
            One of :meth:`blocks`.
        topics
            Names to keep; None keeps all.
        """
        buffer, places = self.message_places(block)
        messages = []
        for start, stop in zip(places[::2], places[1::2], strict=True):
            channel_id, _, time_ns, _ = _MESSAGE_HEAD.unpack_from(buffer, start)
            channel = self.channels[channel_id]
            if topics is None or channel.topic in topics:
                messages.append(ScannedMessage(time_ns, channel, buffer[start + _MESSAGE_HEAD.size : stop]))
        return messages

    def message_places(self, block: _Block) -> tuple[bytes, array[int]]:
        """
        Return the bytes of a block, and where in them each message begins, including its head, and ends.

        Begin and end of one message are followed by those of the next. Channels in the block are noted.

        Raises
        ------
        BagError
            If the block is damaged, or has a message of an unknown channel.

        """
        with self._damage_reported(block.start):
            body = self._bytes[block.start : block.stop]
            if block.opcode == Opcode.MESSAGE:
                return body, self._learn_and_place(body, [(block.opcode, 0, len(body))])
            data = _unpack(body)
            return data, self._learn_and_place(data, records_of(data, 0, len(data)))

    def _walk(self) -> None:
        """Read the records outside chunks, up to the footer or the end of a truncated file."""
        for opcode, start, stop in records_of(self._bytes, len(MAGIC), len(self._bytes)):
            if opcode == Opcode.FOOTER:
                self.complete = self._bytes[stop : stop + len(MAGIC)] == MAGIC
                return
            if opcode not in _TAKEN:
                continue
            with self._damage_reported(start):
                self._take_record(opcode, start, stop)

    def _take_record(self, opcode: int, start: int, stop: int) -> None:
        """Note a block, or use another record outside chunks."""
        if opcode == Opcode.CHUNK:
            first_ns, last_ns = _TIME_SPAN.unpack_from(self._bytes, start)
            if last_ns == 0 and not _has_messages(self._bytes[start:stop]):
                first_ns = _NEVER_NS  # it states 0 for both, as the format wants
            self._blocks.append(_Block(opcode, start, stop, first_ns, last_ns))
        elif opcode == Opcode.MESSAGE:
            time_ns = _MESSAGE_HEAD.unpack_from(self._bytes, start)[2]
            self._blocks.append(_Block(opcode, start, stop, time_ns, time_ns))
        elif opcode == Opcode.HEADER:
            profile = Header.read(_stream(self._bytes[start:stop])).profile
            if profile != "ros2":
                raise BagError(f"{self.path} is not a ROS 2 recording (its MCAP profile is {profile!r})")
        else:
            self._learn(opcode, self._bytes[start:stop])

    def _learn_and_place(self, buffer: bytes, records: Iterable[tuple[int, int, int]]) -> array[int]:
        """Return the places of the messages among some records, and use the other records."""
        places = array("q")
        for opcode, start, stop in records:
            if opcode != Opcode.MESSAGE:
                self._learn(opcode, buffer[start:stop])
                continue
            (channel_id,) = _CHANNEL_ID.unpack_from(buffer, start)
            if channel_id not in self.channels or stop - start < _MESSAGE_HEAD.size:
                raise ValueError(f"a message of {stop - start} bytes on channel {channel_id}")
            places.append(start)
            places.append(stop)
        return places

    def _learn(self, opcode: int, body: bytes) -> None:
        """Keep a schema or a channel."""
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream(body))
            self.schemas.setdefault(schema.id, schema)
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(_stream(body))
            if channel.schema_id not in self.schemas:
                raise ValueError(f"topic {channel.topic} has no message type")
            self.channels.setdefault(channel.id, channel)

    @contextmanager
    def _damage_reported(self, position: int) -> Iterator[None]:
        """Convert all exceptions of the parsers for damaged bytes into one; each compressor has its own."""
        try:
            yield
        except BagError:
            raise
        except Exception as error:
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise BagError(f"{self.path} is damaged at byte {position} ({reason})") from None


def messages_in_time_order(
    files: Sequence[McapScan], topics: Collection[str] | None = None, start_ns: int = 0
) -> Iterator[tuple[McapScan, ScannedMessage]]:
    """Yield the messages of several files by log time; equal times keep the order of the files.

    Blocks overlap slightly in time, so messages wait until no later block can begin before them; only a few
    blocks are in memory.

    Parameters
    ----------
    files
        Files of one bag, in recorded order.
    topics
        Names to keep; None keeps all.
    start_ns
        Time before which messages are left out.
    """
    plan = [(file, block) for file in files for block in file.blocks()]
    horizons_ns = _earliest_later([block.first_ns for _, block in plan])
    time_of = itemgetter(0)
    waiting: list[tuple[int, McapScan, ScannedMessage]] = []
    for (file, block), horizon_ns in zip(plan, horizons_ns, strict=True):
        waiting += [
            (each.time_ns, file, each) for each in file.messages_of(block, topics) if each.time_ns >= start_ns
        ]
        waiting.sort(key=time_of)
        ready = bisect_right(waiting, horizon_ns, key=time_of)
        yield from ((source, each) for _, source, each in waiting[:ready])
        del waiting[:ready]


def _earliest_later(first_ns: Sequence[int]) -> list[int]:
    """Return for each block the earliest time in all later blocks."""
    earliest = _NEVER_NS
    result = []
    for each in reversed(first_ns):
        result.append(earliest)
        earliest = min(earliest, each)
    return result[::-1]


def _has_messages(body: bytes) -> bool:
    """Return whether a chunk has a message; it may contain channels only."""
    data = _unpack(body)
    return any(opcode == Opcode.MESSAGE for opcode, _, _ in records_of(data, 0, len(data)))


def _unpack(body: bytes) -> bytes:
    """Return the records of a chunk, decompressed and checked."""
    chunk = Chunk.read(_stream(body))
    _check_size(chunk)
    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
    data = stream.read(size)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk of {len(data)} bytes should have {chunk.uncompressed_size}")
    return data


def _check_size(chunk: Chunk) -> None:
    """
    Raise ValueError for a chunk that unpacks to more than a recorder writes, by its own or by zstd's size.
    """
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        stated = zstandard.get_frame_parameters(chunk.data).content_size
        if stated != zstandard.CONTENTSIZE_UNKNOWN:  # otherwise no more is unpacked than the chunk states
            size = max(size, stated)
    if size > MOST_CHUNK_BYTES:
        raise ValueError(f"a chunk unpacks to {size} bytes; allowed: at most {MOST_CHUNK_BYTES}")


def _stream(body: bytes) -> ReadDataStream:
    """Return bytes as a stream for the mcap library."""
    return ReadDataStream(BytesIO(body))


def records_of(buffer: bytes | mmap.mmap, start: int, stop: int) -> Iterator[tuple[int, int, int]]:
    """Yield (opcode, start, stop of the body) of each complete record; stop at a truncated one."""
    while start + RECORD_HEAD.size <= stop:
        opcode, length = RECORD_HEAD.unpack_from(buffer, start)
        body = start + RECORD_HEAD.size
        start = body + length
        if opcode == 0 or start > stop:
            return
        yield opcode, body, start
