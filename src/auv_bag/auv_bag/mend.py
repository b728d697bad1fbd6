"""
Repair a bag whose writer was killed or stopped: add the missing end, in place.

Standard readers (rosbag2, rosbags, Foxglove) require an MCAP file to end with a summary. The content of the
file does not change: an incomplete last record is removed, the end of a file is written after the last
complete one, and metadata.yaml is made from the content, as `ros2 bag reindex` does.
"""

from __future__ import annotations

import mmap
import os
import struct
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import get_chunk_data_stream

from auv_bag.bag import find_files, offered_qos
from auv_bag.mcap_scan import MAGIC, RECORD_HEAD, McapScan, records_of
from auv_bag.metadata import METADATA_FILE, information_text, metadata_text, topic_text
from auv_core.machine.file_locks import lock_file
from auv_core.machine.whole_files import WriteError, write_text

_CHUNK_HEAD = struct.Struct("<QQQII")
_COUNT = struct.Struct("<H")
_MESSAGE_HEAD = struct.Struct("<HIQ")
_FOOTER_HEAD = struct.Struct("<BQQQ")
_FOOTER_BYTES = 20
_FIRST_OF_THE_END = (Opcode.DATA_END, Opcode.FOOTER)


def mend_bag(path: Path) -> tuple[str, ...]:
    """
    Repair the files of a bag that have no end; return lines for the user.

    A file that is still being written is left alone.

    Parameters
    ----------
    path
        As for :class:`auv_bag.bag.Bag`.

    Raises
    ------
    BagError
        If there is no bag, or it cannot be read.
    """
    files, notes = find_files(path)
    told = [_mend_file(file, is_alone=len(files) == 1) for file in files]
    return (*filter(None, told), *notes)


def _mend_file(path: Path, *, is_alone: bool) -> str:
    """
    Add the end of a file, and the bag's metadata if it is the only file; return a line for the user, or ''.
    """
    scan = McapScan(path)
    if scan.complete:
        return ""
    try:
        with path.open("r+b") as file:
            lock_file(file.fileno())
            _write_end(file.fileno(), scan, path.parent / METADATA_FILE if is_alone else None)
    except BlockingIOError:
        return f"{path} is still being written; its content so far is read"
    except OSError as error:
        reason = error.strerror or str(error)
        return (
            f"the writer of {path} was killed before it finished; it cannot be repaired ({reason}), but read"
        )
    return f"the writer of {path} was killed before it finished; the file is repaired: all it wrote is used"


@dataclass
class _Contents:
    """The chunks and metadata records of a file for an index, and the end of the last record."""

    stop: int
    index: bytes = b""
    """The message index of the last chunk, which may be incomplete in the file: it follows `stop`."""
    chunks: list[ChunkIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    attachments: int = 0


def _write_end(descriptor: int, scan: McapScan, metadata: Path | None) -> None:
    """Write the end of a file, and the metadata of its bag if given."""
    with mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ) as data:
        contents = _contents(data)
    times_ns, counts = _count_messages(scan)
    information = information_text(scan.path.name, _topics(scan, counts), times_ns)
    last = _bytes_of([Metadata("rosbag2", {"serialized_metadata": information})])
    end = contents.stop + len(contents.index)
    contents.metadata.append(MetadataIndex(length=len(last), name="rosbag2", offset=end))
    statistics = Statistics(
        attachment_count=contents.attachments,
        channel_count=len(scan.channels),
        channel_message_counts=dict(counts),
        chunk_count=len(contents.chunks),
        message_count=counts.total(),
        message_end_time=times_ns[1],
        message_start_time=times_ns[0],
        metadata_count=len(contents.metadata),
        schema_count=len(scan.schemas),
    )
    groups: list[tuple[int, Sequence[McapRecord]]] = [
        (Opcode.SCHEMA, list(scan.schemas.values())),
        (Opcode.CHANNEL, list(scan.channels.values())),
        (Opcode.STATISTICS, [statistics]),
        (Opcode.CHUNK_INDEX, contents.chunks),
        (Opcode.METADATA_INDEX, contents.metadata),
    ]
    last += _bytes_of([DataEnd(0)])
    try:
        tail = last + _summary(end + len(last), groups)
        _replace_tail(descriptor, contents.stop, contents.index + tail)
        _write_metadata(metadata, information)
    except OSError:  # the disk is full, but has space for the removed part; a summary is optional
        _replace_tail(descriptor, contents.stop, _SHORTEST_END)
        with suppress(WriteError):
            _write_metadata(metadata, information)


def _write_metadata(path: Path | None, information: str) -> None:
    if path is not None:
        write_text(path, metadata_text(information))


def _contents(data: mmap.mmap) -> _Contents:
    """Read the records of a file, up to its truncation or to the end of an earlier repair."""
    found = _Contents(stop=len(MAGIC))
    is_indexed = True
    for opcode, start, stop in records_of(data, len(MAGIC), len(data)):
        begin = start - RECORD_HEAD.size
        if opcode in _FIRST_OF_THE_END:
            break
        is_indexed = opcode != Opcode.CHUNK and (is_indexed or opcode != Opcode.MESSAGE_INDEX)
        if opcode == Opcode.CHUNK:
            found.chunks.append(_chunk_index(data, begin, stop))
        elif opcode == Opcode.MESSAGE_INDEX and found.chunks:
            chunk = found.chunks[-1]
            chunk.message_index_offsets[_COUNT.unpack_from(data, start)[0]] = begin
            chunk.message_index_length += stop - begin
        elif opcode == Opcode.METADATA:
            name = Metadata.read(ReadDataStream(BytesIO(data[start:stop]))).name
            found.metadata.append(MetadataIndex(length=stop - begin, name=name, offset=begin))
        elif opcode == Opcode.ATTACHMENT:
            found.attachments += 1
        found.stop = stop
    if not is_indexed:
        _index_last_chunk(data, found)
    return found


def _index_last_chunk(data: mmap.mmap, found: _Contents) -> None:
    """Make the message index of the last chunk again: the writer may have ended within it."""
    chunk = found.chunks[-1]
    found.stop = chunk.chunk_start_offset + chunk.chunk_length
    record = data[chunk.chunk_start_offset + RECORD_HEAD.size : found.stop]
    stream, size = get_chunk_data_stream(Chunk.read(ReadDataStream(BytesIO(record))))
    unpacked = stream.read(size)
    messages: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for opcode, start, _ in records_of(unpacked, 0, size):
        if opcode == Opcode.MESSAGE:
            channel, _, time_ns = _MESSAGE_HEAD.unpack_from(unpacked, start)
            messages[channel].append((time_ns, start - RECORD_HEAD.size))
    chunk.message_index_offsets = {}
    for channel, entries in messages.items():
        chunk.message_index_offsets[channel] = found.stop + len(found.index)
        found.index += _bytes_of([MessageIndex(channel_id=channel, records=entries)])
    chunk.message_index_length = len(found.index)


def _chunk_index(data: mmap.mmap, begin: int, stop: int) -> ChunkIndex:
    """Return the index of a chunk whose record has these bounds."""
    first_ns, last_ns, size, _, word = _CHUNK_HEAD.unpack_from(data, begin + RECORD_HEAD.size)
    compression = begin + RECORD_HEAD.size + _CHUNK_HEAD.size
    return ChunkIndex(
        chunk_length=stop - begin,
        chunk_start_offset=begin,
        compression=data[compression : compression + word].decode(),
        compressed_size=stop - (compression + word + 8),
        message_end_time=last_ns,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=first_ns,
        uncompressed_size=size,
    )


def _count_messages(scan: McapScan) -> tuple[tuple[int, int], Counter[int]]:
    """Return first and last time (ns; zeros for no message), and the number of messages by channel."""
    first_ns, last_ns = 2**63, 0
    counts: Counter[int] = Counter()
    for block in scan.blocks():
        for message in scan.messages_of(block, None):
            counts[message.channel.id] += 1
            first_ns, last_ns = min(first_ns, message.time_ns), max(last_ns, message.time_ns)
    return (first_ns, last_ns) if counts else (0, 0), counts


def _topics(scan: McapScan, counts: Counter[int]) -> Iterable[tuple[str, int]]:
    """Yield the metadata of each topic, and how many messages it has."""
    for channel in scan.channels.values():
        text = topic_text(
            channel.topic,
            scan.schemas[channel.schema_id].name,
            channel.metadata.get("topic_type_hash", ""),
            offered_qos(channel.metadata.get("offered_qos_profiles", "")),
        )
        yield text, counts[channel.id]


def _summary(start: int, groups: Iterable[tuple[int, Sequence[McapRecord]]]) -> bytes:
    """Return the end of a file after its data: summary, offsets, footer and magic bytes."""
    summary, offsets = b"", []
    for opcode, members in groups:
        if members:
            body = _bytes_of(members)
            offsets.append(
                SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(body))
            )
            summary += body
    offsets_start = start + len(summary)
    summary += _bytes_of(offsets)
    head = _FOOTER_HEAD.pack(Opcode.FOOTER, _FOOTER_BYTES, start, offsets_start)
    footer = Footer(
        summary_crc=zlib.crc32(head, zlib.crc32(summary)),
        summary_offset_start=offsets_start,
        summary_start=start,
    )
    return summary + _bytes_of([footer]) + MAGIC


def _bytes_of(members: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for member in members:
        member.write(builder)
    return bytes(builder.end())


_SHORTEST_END = _bytes_of([DataEnd(0), Footer(0, 0, 0)]) + MAGIC
"""The end of a file without a summary: readers go through the file instead."""


def _replace_tail(descriptor: int, start: int, tail: bytes) -> None:
    """Let a file end with `tail` from `start` on, or at `start` if there is no space for it."""
    os.ftruncate(descriptor, start)
    try:
        written = 0
        while written < len(tail):
            written += os.pwrite(descriptor, tail[written:], start + written)
    except OSError:
        os.ftruncate(descriptor, start)
        raise
