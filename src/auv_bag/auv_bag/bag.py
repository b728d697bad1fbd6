"""An opened bag: its topics and its messages in order of time.

Works without ROS and without the build: message types come from the definitions in the bag.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from auv_bag.columns import Batch, ColumnReader
from auv_bag.mcap_scan import McapScan, messages_in_time_order
from auv_bag.metadata import METADATA_FILE
from auv_bag.rows import message_rows
from auv_bag.writer import BagError

_YAML_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # ten times as fast, if available
_MOST_YAML_BYTES = 8_000_000
"""The metadata.yaml of 250 vehicles has half of this size."""
_DEEPEST_YAML = 20
_INFORMATION = "rosbag2_bagfile_information"
_NO_YAML = (
    yaml.YAMLError,
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    RecursionError,
)


class RecordedMessage(NamedTuple):
    """One message of a bag."""

    time_ns: int
    topic: str
    type_name: str
    data: bytes


@dataclass(frozen=True)
class RecordedTopic:
    """A bag's data about one topic."""

    name: str
    type_name: str
    definition: str
    type_hash: str
    offered_qos: tuple[dict[str, Any], ...]


@dataclass
class Bag:
    """An opened bag.

    Parameters
    ----------
    path
        A bag folder, a results folder with a ``bag`` in it, or an MCAP file.

    Attributes
    ----------
    folder
        Folder of the MCAP files.
    topics
        Recorded topics by name, sorted.
    complete
        False if its writer was killed before it finished the file; the written messages can still be read.
    notes
        Harmless defects, one line each.

    Raises
    ------
    BagError
        If there is no bag, or it cannot be read; the message is one line.
    """

    path: Path
    folder: Path = field(init=False)
    topics: dict[str, RecordedTopic] = field(init=False)
    complete: bool = field(init=False)
    notes: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        """Find and open the files."""
        paths, self.notes = find_files(self.path)
        self.folder = paths[0].parent
        self._files = [McapScan(path) for path in paths]
        self.complete = all(file.complete for file in self._files)
        self.topics = self._find_topics()

    def messages(self, topics: Collection[str] | None = None, start_ns: int = 0) -> Iterator[RecordedMessage]:
        """Yield messages in order of time, equal times in recorded order.

        Parameters
        ----------
        topics
            Names to keep; None keeps all.
        start_ns
            Time before which messages are left out.
        """
        for file, message in messages_in_time_order(self._files, topics, start_ns):
            channel = message.channel
            schema = file.schemas[channel.schema_id]
            yield RecordedMessage(message.time_ns, channel.topic, schema.name, message.data)

    def columns(self, topics: Collection[str]) -> Iterator[tuple[str, Iterator[Batch], int]]:
        """Yield messages as columns: their topic, batches of them, and their number including malformed ones.

        They come in the order of the files. Each batch has the order in which its messages were recorded.

        Parameters
        ----------
        topics
            Names to keep.
        """
        readers: dict[tuple[str, str], ColumnReader] = {}
        for rows in message_rows(self._files, topics):
            key = rows.topic, rows.type_name
            if key not in readers:
                readers[key] = ColumnReader(self._types, rows.type_name)
            yield rows.topic, readers[key].read(rows), len(rows.data)

    def span_ns(self) -> tuple[int, int]:
        """Return the first and the last time in the bag (ns); (0, 0) for an empty one."""
        blocks = [b for file in self._files for b in file.blocks() if b.first_ns <= b.last_ns]
        if not blocks:
            return 0, 0
        return min(block.first_ns for block in blocks), max(block.last_ns for block in blocks)

    def decode(self, message: RecordedMessage) -> Any:
        """Return a message as an object with the fields of its definition."""
        try:
            return self._types.deserialize_cdr(message.data, message.type_name)
        except Exception as error:  # the library has no specific exception for malformed bytes
            reason = " ".join(str(error).split())
            raise BagError(
                f"{self.folder}: a message of {message.topic} cannot be decoded ({reason})"
            ) from None

    @cached_property
    def _types(self) -> Typestore:
        return _typestore(self.topics.values())

    def _find_topics(self) -> dict[str, RecordedTopic]:
        """Collect the topics of all files."""
        found: dict[str, RecordedTopic] = {}
        for file in self._files:
            file.find_channels()
            for channel in file.channels.values():
                schema = file.schemas[channel.schema_id]
                found[channel.topic] = RecordedTopic(
                    name=channel.topic,
                    type_name=schema.name,
                    definition=schema.data.decode(errors="replace"),
                    type_hash=channel.metadata.get("topic_type_hash", ""),
                    offered_qos=offered_qos(channel.metadata.get("offered_qos_profiles", "")),
                )
        return dict(sorted(found.items()))


def _typestore(topics: Collection[RecordedTopic]) -> Typestore:
    """Register the definitions of all topics, without those that are none."""
    store = get_typestore(Stores.EMPTY)
    types: dict[str, Any] = {}
    for name, definition in {topic.type_name: topic.definition for topic in topics}.items():
        with suppress(Exception):  # each layer of the library has errors of its own
            types.update(get_types_from_msg(definition, name))
    store.register(types)
    return store


class _UnlikelyYamlError(ValueError):
    """Raised for YAML that no recorder writes; the message is a short reason."""


def _load_yaml(text: str) -> Any:
    """
    Return the content of a recorder's YAML, which is short, flat and without aliases; raise for any other.
    """
    if len(text) > _MOST_YAML_BYTES:
        raise _UnlikelyYamlError(f"it is longer than {_MOST_YAML_BYTES} bytes")
    depth = 0
    for event in yaml.parse(text, _YAML_LOADER):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST_YAML or isinstance(event, yaml.AliasEvent):
            raise _UnlikelyYamlError(f"it has aliases, or is nested more than {_DEEPEST_YAML} deep")
    return yaml.load(text, _YAML_LOADER)  # noqa: S506 - it is a safe loader


def offered_qos(text: str) -> tuple[dict[str, Any], ...]:
    """Return the QoS profiles of a channel; none if they cannot be read."""
    try:
        profiles = _load_yaml(text)
    except _NO_YAML:
        return ()
    return tuple(each for each in profiles if isinstance(each, dict)) if isinstance(profiles, list) else ()


def find_files(path: Path) -> tuple[list[Path], tuple[str, ...]]:
    """
    Return the MCAP files of a bag in recorded order, and notes.

    Raises
    ------
    BagError
        If there are none.
    """
    if path.is_file() and path.suffix == ".mcap":
        return [path], ()
    if not path.is_dir():
        raise BagError(f"no bag at {path}: no such folder")
    for folder in (path, path / "bag"):
        files = sorted(folder.glob("*.mcap"), key=_file_number)
        metadata = folder / METADATA_FILE
        if not metadata.is_file():
            if files:
                return files, ()
            continue
        try:
            return _files_by_metadata(metadata), ()
        except _DamagedMetadataError as error:
            if not files:
                raise BagError(f"{metadata} is not the metadata of a bag") from None
            return files, (f"{metadata} is damaged ({error}); the .mcap files beside it are read",)
    raise BagError(f"no bag in {path}: neither {METADATA_FILE} nor an .mcap file, here or in {path / 'bag'}")


class _DamagedMetadataError(Exception):
    """Raised for a metadata.yaml that does not name the files of a bag; the message is a short reason."""


def _files_by_metadata(metadata: Path) -> list[Path]:
    """Return the files that metadata.yaml names."""
    information = _information(metadata)
    storage, names = information.get("storage_identifier"), information.get("relative_file_paths")
    if not storage:
        raise _DamagedMetadataError("it names no storage")
    if not isinstance(names, list):
        raise _DamagedMetadataError("its relative_file_paths is not a list")
    folder = metadata.parent
    if storage != "mcap":
        raise BagError(f"{folder} is stored as {storage}; only mcap is read (`ros2 bag convert` makes it)")
    files = [folder / Path(str(name)).name for name in names]
    missing = [file.name for file in files if not file.is_file()]
    if missing or not files:
        raise BagError(f"{folder} lacks {', '.join(missing) or 'its .mcap file'}")
    return files


def _information(metadata: Path) -> dict[str, Any]:
    """Return the content of metadata.yaml about its bag."""
    try:
        with metadata.open(encoding="utf-8") as file:
            content = _load_yaml(file.read(_MOST_YAML_BYTES + 1))
    except OSError as error:
        raise _DamagedMetadataError(error.strerror or "it cannot be read") from None
    except UnicodeDecodeError:
        raise _DamagedMetadataError("it is not UTF-8 text") from None
    except _UnlikelyYamlError as error:
        raise _DamagedMetadataError(str(error)) from None
    except _NO_YAML:
        raise _DamagedMetadataError("it is not YAML") from None
    information = content.get(_INFORMATION) if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise _DamagedMetadataError(f"it has no {_INFORMATION}")
    return information


def _file_number(path: Path) -> tuple[int, str]:
    """Sort key of ``bag_0.mcap``, ``bag_1.mcap``, ... ``bag_10.mcap``."""
    number = path.stem.rpartition("_")[2]
    return (int(number) if number.isdigit() else -1, path.name)
