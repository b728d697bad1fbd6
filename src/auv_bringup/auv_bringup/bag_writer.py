"""Write a rosbag2 directory (MCAP) as Jazzy's own recorder writes it, so that a crash loses little.

A bag ``results/x/bag`` is the folder ``bag`` with ``bag_0.mcap`` (the name that ``ros2 bag reindex`` looks
for) and ``metadata.yaml`` (version 9). What a killed writer leaves behind can be read:

* chunks are small (64 kB before compression) and go to the file, unbuffered, when they are full, so that
  at most the chunk in progress is lost;
* schemas and channels stand in the chunks, before their first message, so that a file without a summary
  can be read from its start;
* the ``rosbag2`` metadata record is written at the start too, so that a reindexer knows the version;
* ``metadata.yaml`` is there from the start and is replaced, atomically, at every checkpoint.

Chunks are compressed with zstd: the numbers of a slowly moving flock shrink to about a quarter for some
0.2 ms of processor time a chunk, and every MCAP reader (rosbag2's, rosbags, Foxglove) reads it.
"""

from __future__ import annotations

import fcntl
import os
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from auv_bringup.bag_metadata import METADATA_FILE, dump, information_text, metadata_text, topic_text
from auv_bringup.message_definitions import MessageType

CHUNK_BYTES = 64 * 1024
INFINITE_NS = 2**63 - 1


class BagError(Exception):
    """A bag that cannot be written or read; the message is one line."""


@dataclass(frozen=True)
class Qos:
    """The QoS that one publisher of a recorded topic offered, in rosbag2's words."""

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
        """Return the mapping that metadata.yaml holds; a duration is split into seconds and nanoseconds."""
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


class _UnbufferedFile:
    """
    A new file whose every write reaches the operating system before it returns.

    A lock (flock) tells others that it is still being written; it ends with this process, however that ends.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("xb", buffering=0)
        with suppress(OSError):  # a file system without locks
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._position = 0

    def write(self, data: bytes) -> int:
        view = memoryview(data)
        while view:
            written = self._file.write(view)
            self._position += written
            view = view[written:]
        return len(data)

    def tell(self) -> int:
        return self._position

    def flush(self) -> None:
        """Do nothing: nothing is held back."""

    def close(self) -> None:
        self._file.close()


class BagWriter:
    """Writes one bag. Not thread-safe.

    Parameters
    ----------
    bag_dir
        Folder to create; it must not exist.
    ros_distro
        Name of the ROS distribution that the bag says it was made by.

    Raises
    ------
    BagError
        If the folder exists already or cannot be made.
    """

    def __init__(self, bag_dir: Path, *, ros_distro: str = "jazzy", chunk_bytes: int = CHUNK_BYTES) -> None:
        self._dir = bag_dir
        self._file_name = f"{bag_dir.resolve().name}_0.mcap"
        self._ros_distro = ros_distro
        self._first_ns, self._last_ns = INFINITE_NS, 0
        self._topic_texts: list[str] = []
        self._counts: list[int] = []
        self._schema_ids: dict[str, int] = {}
        self._file = self._create()
        self._mcap = Writer(self._file, chunk_size=chunk_bytes, compression=CompressionType.ZSTD)
        self._mcap.start(profile="ros2", library="shoal")
        self._add_metadata_record()
        self._replacing: threading.Thread | None = None
        self._replace_metadata(metadata_text(self._information()))

    @property
    def message_count(self) -> int:
        """Number of messages taken so far."""
        return sum(self._counts)

    @property
    def byte_count(self) -> int:
        """Size of the MCAP file so far; the chunk in progress is not in it."""
        return self._file.tell()

    def add_topic(self, topic: Topic) -> int:
        """Register a topic and return its channel id."""
        if topic.type.name not in self._schema_ids:
            self._schema_ids[topic.type.name] = self._mcap.register_schema(
                topic.type.name, "ros2msg", topic.type.definition.encode()
            )
        offered_qos = [each.to_dict() for each in topic.offered_qos]
        channel = self._mcap.register_channel(
            topic.name,
            "cdr",
            self._schema_ids[topic.type.name],
            {
                "offered_qos_profiles": dump(offered_qos),
                "topic_type_hash": topic.type.type_hash,
            },
        )
        self._topic_texts.append(topic_text(topic.name, topic.type.name, topic.type.type_hash, offered_qos))
        self._counts.append(0)
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
        if time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns

    def checkpoint(self) -> None:
        """
        Bring everything taken so far to the file and bring metadata.yaml up to date.

        The latter in a thread, since a disk that is busy takes long to replace a file, and a flight would
        wait.
        """
        self._mcap.flush()
        if self._replacing is None or not self._replacing.is_alive():
            text = metadata_text(self._information())
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
        self._replace_metadata(metadata_text(self._information()))

    def _create(self) -> _UnbufferedFile:
        """Make the folder and the MCAP file in it."""
        try:
            self._dir.mkdir(parents=True)
            return _UnbufferedFile(self._dir / self._file_name)
        except FileExistsError:
            raise BagError(f"{self._dir} exists already; a bag is never overwritten") from None
        except OSError as error:
            raise BagError(f"cannot create the bag {self._dir}: {error.strerror}") from None

    def _information(self) -> str:
        return information_text(
            self._file_name,
            zip(self._topic_texts, self._counts, strict=True),
            (self._first_ns, self._last_ns),
            self._ros_distro,
        )

    def _add_metadata_record(self) -> None:
        """Put what metadata.yaml says into the MCAP file too, where rosbag2 looks for it."""
        self._mcap.add_metadata("rosbag2", {"serialized_metadata": self._information()})

    def _replace_metadata(self, text: str) -> None:
        """Replace metadata.yaml in one step."""
        temporary = self._dir / f".{METADATA_FILE}.{os.getpid()}"
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(self._dir / METADATA_FILE)

    def _try_replace_metadata(self, text: str) -> None:
        with suppress(OSError):  # who writes the next chunk finds out
            self._replace_metadata(text)


def _split_duration(duration_ns: int) -> dict[str, int]:
    """Return a duration as rmw does; 9223372036 s and 854775807 ns is "infinite"."""
    return {"sec": duration_ns // 1_000_000_000, "nsec": duration_ns % 1_000_000_000}
