"""Write a rosbag2 directory (MCAP) like Jazzy's own recorder, so that a crash loses few messages.

A bag ``results/x/bag`` is the folder ``bag`` with ``bag_0.mcap`` (the name that ``ros2 bag reindex`` looks
for) and ``metadata.yaml`` (version 9). The bag of a killed writer can be read:

* chunks are small (64 kB before compression) and are written, unbuffered, when they are full; messages that
  wait longer for a chunk are provisionally written after the last one (:mod:`auv_bag.file`);
* schemas and channels are in the chunks, before their first message, so that a file without a summary
  can be read from its start;
* the ``rosbag2`` metadata record is also written at the start, so that a reindexer knows the version;
* ``metadata.yaml`` exists from the start and is replaced atomically at every checkpoint.

Chunks are compressed with zstd: the numbers of a slowly moving flock shrink to about a quarter for some
0.2 ms of processor time a chunk, and every MCAP reader (rosbag2's, rosbags, Foxglove) reads it.

Equal messages in equal order make equal files, independently of their arrival times.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from auv_bag.definitions import MessageType
from auv_bag.file import BagFile, TimedMessage, chunk_of
from auv_bag.metadata import METADATA_FILE, dump, information_text, metadata_text, topic_text
from auv_core.machine.whole_files import reason, write_text

CHUNK_BYTES = 64 * 1024
INFINITE_NS = 2**63 - 1


class BagError(Exception):
    """Raised if a bag cannot be written or read; the message is one line."""


@dataclass(frozen=True)
class Qos:
    """The QoS that one publisher of a recorded topic offered, in rosbag2's terms."""

    history: str = "keep_all"
    depth: int = 0
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    liveliness: str = "automatic"
    liveliness_lease_duration_ns: int = INFINITE_NS
    avoid_ros_namespace_conventions: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return the mapping in metadata.yaml; a duration is split into seconds and nanoseconds."""
        return {
            name.removesuffix("_ns"): _split_duration(value) if name.endswith("_ns") else value
            for name, value in asdict(self).items()
        }


@dataclass(frozen=True)
class Topic:
    """One recorded topic."""

    name: str
    type: MessageType
    offered_qos: tuple[Qos, ...] = (Qos(),)


class BagWriter:
    """Writes one bag. Not thread-safe.

    Parameters
    ----------
    bag_dir
        Folder to create; it must not exist, and the folder around it must.
    ros_distro
        Name of the ROS distribution in the bag.

    Raises
    ------
    BagError
        If the folder already exists or cannot be made.
    """

    def __init__(self, bag_dir: Path, *, ros_distro: str = "jazzy", chunk_bytes: int = CHUNK_BYTES) -> None:
        self._dir = bag_dir
        self._file_name = f"{bag_dir.resolve().name}_0.mcap"
        self._ros_distro = ros_distro
        self._first_ns, self._last_ns = INFINITE_NS, 0
        self._topics: list[Topic] = []
        self._topic_texts: list[str] = []
        self._counts: list[int] = []
        self._schema_ids: dict[str, int] = {}
        self._file = self._create()
        self._mcap = Writer(self._file, chunk_size=chunk_bytes, compression=CompressionType.ZSTD)
        self._mcap.start(profile="ros2", library="shoal")
        self._add_metadata_record()
        self._chunk: list[TimedMessage] = []
        self._chunk_at = self._saved_at = self._file.tell()
        self._saved_count = 0
        self._replacing: threading.Thread | None = None
        write_text(self._dir / METADATA_FILE, metadata_text(self._information()))

    @property
    def message_count(self) -> int:
        """Number of messages so far."""
        return sum(self._counts)

    @property
    def byte_count(self) -> int:
        """Size of the MCAP file so far, without the chunk in progress."""
        return self._file.tell()

    def add_topic(self, topic: Topic) -> int:
        """Register a topic and return its channel id."""
        offered_qos = [each.to_dict() for each in topic.offered_qos]
        self._topic_texts.append(topic_text(topic.name, topic.type.name, topic.type.type_hash, offered_qos))
        self._topics.append(topic)
        self._counts.append(0)
        channel = _register(self._mcap, topic, self._schema_ids)
        self._note_chunk()
        return channel

    def write(self, channel: int, data: bytes, time_ns: int) -> None:
        """Append one serialised message.

        Parameters
        ----------
        channel
            From :meth:`add_topic`.
        data
            CDR bytes with their encapsulation header.
        time_ns
            Log and publish time, not negative.
        """
        self._mcap.add_message(channel, time_ns, data, time_ns, self._counts[channel - 1])
        self._counts[channel - 1] += 1
        self._chunk.append(TimedMessage(time_ns, channel, data))
        self._note_chunk()
        if time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns

    def checkpoint(self, held: Sequence[TimedMessage] = ()) -> None:
        """
        Write waiting messages provisionally to the file, and update metadata.yaml.

        If chunks were written since the last call, the waiting messages are recent and are not written. The
        metadata is replaced in a thread, since a busy disk takes long and a flight would wait.

        Parameters
        ----------
        held
            Messages that will be written later.
        """
        waiting = [*self._chunk, *held]
        if self._saved_at == self._chunk_at and len(waiting) > self._saved_count:
            self._file.put_tail(chunk_of(waiting, self._register_all))
            self._saved_count = len(waiting)
        self._saved_at = self._chunk_at
        if self._replacing is None or not self._replacing.is_alive():
            text = metadata_text(self._information(held))
            self._replacing = threading.Thread(target=self._try_replace_metadata, args=(text,), daemon=True)
            self._replacing.start()

    def close(self) -> None:
        """Finish the file with its summary and write the last metadata.yaml."""
        self._mcap.flush()
        self._add_metadata_record()
        self._mcap.finish()
        self._file.close()
        if self._replacing is not None:
            self._replacing.join()
        write_text(self._dir / METADATA_FILE, metadata_text(self._information()))

    def _note_chunk(self) -> None:
        """Drop the messages of a chunk that was written."""
        if self._file.tell() != self._chunk_at:
            self._chunk, self._chunk_at, self._saved_count = [], self._file.tell(), 0

    def _register_all(self, writer: Writer) -> None:
        schema_ids: dict[str, int] = {}
        for topic in self._topics:
            _register(writer, topic, schema_ids)

    def _create(self) -> BagFile:
        """
        Make the folder and the MCAP file in it.

        The folder around it must exist: if results are moved while a flight begins, they are not made again
        at their old place.
        """
        try:
            self._dir.mkdir()
            return BagFile(self._dir / self._file_name)
        except FileExistsError:
            raise BagError(f"{self._dir} exists already; a bag is never overwritten") from None
        except OSError as error:
            raise BagError(f"cannot create the bag {self._dir}: {reason(error)}") from None

    def _information(self, held: Sequence[TimedMessage] = ()) -> str:
        held_counts = Counter(each.channel for each in held)
        counts = [count + held_counts[channel] for channel, count in enumerate(self._counts, start=1)]
        times_ns = [each.time_ns for each in held]
        span_ns = min([self._first_ns, *times_ns]), max([self._last_ns, *times_ns])
        pairs = zip(self._topic_texts, counts, strict=True)
        return information_text(self._file_name, pairs, span_ns, self._ros_distro)

    def _add_metadata_record(self) -> None:
        """Write the content of metadata.yaml into the MCAP file, too, where rosbag2 looks for it."""
        self._mcap.add_metadata("rosbag2", {"serialized_metadata": self._information()})

    def _try_replace_metadata(self, text: str) -> None:
        with suppress(OSError):  # the next write of a chunk reports it
            write_text(self._dir / METADATA_FILE, text)


def _register(writer: Writer, topic: Topic, schema_ids: dict[str, int]) -> int:
    """Register a topic, and its type if that is new; return its channel's number, counted from 1."""
    name = topic.type.name
    if name not in schema_ids:
        schema_ids[name] = writer.register_schema(name, "ros2msg", topic.type.definition.encode())
    metadata = {
        "offered_qos_profiles": dump([each.to_dict() for each in topic.offered_qos]),
        "topic_type_hash": topic.type.type_hash,
    }
    return writer.register_channel(topic.name, "cdr", schema_ids[name], metadata)


def _split_duration(duration_ns: int) -> dict[str, int]:
    """Return a duration as in rmw; 9223372036 s and 854775807 ns mean "infinite"."""
    return {"sec": duration_ns // 1_000_000_000, "nsec": duration_ns % 1_000_000_000}
