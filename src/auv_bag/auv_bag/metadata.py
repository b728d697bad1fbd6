"""The text of a bag's metadata.yaml, as Jazzy's own recorder writes it."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

import yaml

METADATA_VERSION = 9
ROS_DISTRO = "jazzy"
METADATA_FILE = "metadata.yaml"


def topic_text(name: str, type_name: str, type_hash: str, offered_qos: Sequence[dict[str, Any]]) -> str:
    """
    Return a topic's entry without its last line, the message count.

    Parameters
    ----------
    name, type_name, type_hash
        Name, message type and type hash of the topic.
    offered_qos
        QoS that its publishers offer, one mapping in rosbag2's terms for each.

    """
    metadata = {
        "name": name,
        "type": type_name,
        "serialization_format": "cdr",
        "offered_qos_profiles": list(offered_qos),
        "type_description_hash": type_hash,
    }
    return "  - " + textwrap.indent(dump({"topic_metadata": metadata}), "    ").removeprefix("    ")


def information_text(
    file_name: str, topics: Iterable[tuple[str, int]], span_ns: tuple[int, int], ros_distro: str = ROS_DISTRO
) -> str:
    """
    Return the content below `rosbag2_bagfile_information`, in the order of Jazzy's recorder.

    Parameters
    ----------
    file_name
        The bag's one MCAP file.
    topics
        The `topic_text` and the number of messages of each topic. The texts are made only once, when a topic
        is added, since this function is called repeatedly while messages wait.
    span_ns
        First and last time in the bag (ns).
    ros_distro
        Name of the ROS distribution in the bag.

    """
    entries = list(topics)
    message_count = sum(count for _, count in entries)
    first_ns, last_ns = span_ns
    span = {
        "duration": {"nanoseconds": max(0, last_ns - first_ns)},
        "starting_time": {"nanoseconds_since_epoch": first_ns},
    }
    head = {
        "version": METADATA_VERSION,
        "storage_identifier": "mcap",
        **span,
        "message_count": message_count,
    }
    file = {"path": file_name, **dict(reversed(span.items())), "message_count": message_count}
    tail = {
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [file],
        "custom_data": None,
        "ros_distro": ros_distro,
    }
    lines = [f"{text}\n    message_count: {count}" for text, count in entries]
    return "\n".join([dump(head), f"topics_with_message_count:{'' if lines else ' []'}", *lines, dump(tail)])


def metadata_text(information: str) -> str:
    """Return the text of metadata.yaml for an `information_text`."""
    indented = information.replace("\n", "\n  ")
    return f"rosbag2_bagfile_information:\n  {indented}\n"


class _Dumper(yaml.SafeDumper):
    """Block style like yaml-cpp: indented sequences, `~` for null, no anchors."""

    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
        super().increase_indent(flow, False)

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_representer(type(None), lambda dumper, _: dumper.represent_scalar("tag:yaml.org,2002:null", "~"))
_Dumper.add_representer(
    str,
    lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style=None if text else '"'),
)


def dump(value: dict[str, Any] | Sequence[Any]) -> str:
    """Serialise a value as block-style YAML without a final line break."""
    return yaml.dump(value, Dumper=_Dumper, sort_keys=False, default_flow_style=False, width=10_000).strip()
