"""Message definitions, type hashes and stamp positions, read from the installed interface packages.

A bag's data about a message type come from two files of its package's share folder:
``msg/<Type>.msg`` (the definition) and ``msg/<Type>.json`` (the type description, with its hash). No ROS
module is imported: the prefixes are those of ``AMENT_PREFIX_PATH``.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from auv_core.cdr import COUNT, STAMP_AT
from auv_core.stamp import STAMP_NUMBERS

SEPARATOR = "=" * 80
_FIELD_TYPE = re.compile(r"(?:^|\n)\s*([a-zA-Z0-9_/]+)(?:\[[^\]]*\])?\s+")
_FIRST_FIELD = re.compile(r"^\s*([a-zA-Z0-9_/]+)(\[[^\]]*\])?\s+[a-zA-Z]\w*\b(?!\s*=)", re.MULTILINE)
_PRIMITIVES = frozenset(
    {"bool", "byte", "char", "string", "float32", "float64"}
    | {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
)
_FIRST_OF_LIST_AT = STAMP_AT + COUNT.size
_STAMPED_FIRST_FIELDS = frozenset({"std_msgs/Header", "Header", "builtin_interfaces/Time", "Time"})


class DefinitionError(Exception):
    """Raised if the definition or hash of a message type is not found."""


@dataclass(frozen=True)
class MessageType:
    """A bag's data about one message type."""

    name: str
    """Full name, ``nav_msgs/msg/Odometry``."""
    definition: str
    """Root ``.msg`` text followed by the blocks of every type that it uses."""
    type_hash: str
    """``RIHS01_...``, the hash that the type has on the wire."""


def share_folders(environment: Mapping[str, str] = os.environ) -> list[Path]:
    """Return the ``share`` folders of every prefix in ``AMENT_PREFIX_PATH``, first one first."""
    prefixes = environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(prefix) / "share" for prefix in prefixes if prefix]


def load_message_type(name: str, shares: Sequence[Path] | None = None) -> MessageType:
    """Read the full definition and the hash of one type.

    Parameters
    ----------
    name
        Full type name, ``package/msg/Type``.
    shares
        Share folders to search; by default those of the environment.

    Raises
    ------
    DefinitionError
        If a file is missing or does not name the type.
    """
    folders = share_folders() if shares is None else list(shares)
    return MessageType(
        name=name,
        definition=full_definition(name, lambda each: _message_file(each, ".msg", folders).read_text()),
        type_hash=_type_hash(name, _message_file(name, ".json", folders)),
    )


def full_definition(name: str, read: Callable[[str], str]) -> str:
    """Concatenate a definition with those of every type that it uses, in the order of the rosbag2 recorder.

    Depth first, the dependencies of one file in alphabetical order, each type once.

    Parameters
    ----------
    name
        Root type, ``package/msg/Type``.
    read
        Returns the ``.msg`` text of a type.
    """
    seen: set[str] = set()

    def expand(each: str) -> str:
        text = read(each)
        blocks = [text]
        for dependency in _dependencies(text, each.split("/")[0]):
            if dependency not in seen:
                seen.add(dependency)
                blocks.append(f"\n{SEPARATOR}\nMSG: {dependency}\n{expand(dependency)}")
        return "".join(blocks)

    return expand(name)


def stamp_offset(definition: str) -> int | None:
    """Return the offset of the stamp in the CDR bytes of a message, or None for a type without one.

    A type begins with a header or a time, or is a sequence of such types; then it is the first element's
    stamp, after the length.
    """
    first, *others = definition.split(f"\n{SEPARATOR}\nMSG: ")
    blocks = {block.partition("\n")[0].strip(): block.partition("\n")[2] for block in others}
    match = _FIRST_FIELD.search(first)
    if match is None:
        return None
    type_name, array = match.groups()
    if type_name in _STAMPED_FIRST_FIELDS and not array:
        return STAMP_AT
    element = _FIRST_FIELD.search(_block(blocks, type_name)) if array == "[]" else None
    if element is not None and element[1] in _STAMPED_FIRST_FIELDS and not element[2]:
        return _FIRST_OF_LIST_AT
    return None


def read_stamp_ns(data: bytes, offset: int) -> int | None:
    """Return the stamp in a message's CDR bytes as nanoseconds, or None for an empty sequence.

    Parameters
    ----------
    data
        Serialised message, little-endian CDR with its encapsulation header.
    offset
        From :func:`stamp_offset`.
    """
    if offset == _FIRST_OF_LIST_AT and data[STAMP_AT:_FIRST_OF_LIST_AT] == b"\0\0\0\0":
        return None
    stamp: tuple[int, int] = STAMP_NUMBERS.unpack_from(data, offset)
    sec, nanosec = stamp
    return sec * 1_000_000_000 + nanosec


def _block(blocks: Mapping[str, str], type_name: str) -> str:
    """Return the definition of a used type, named with or without its package."""
    if type_name in blocks:
        return blocks[type_name]
    return next((text for name, text in blocks.items() if name.split("/")[-1] == type_name), "")


def _dependencies(text: str, package: str) -> list[str]:
    """Return the types that a definition uses, as ``package/Type``, sorted."""
    names = {match[1] for match in _FIELD_TYPE.finditer(text)} - _PRIMITIVES
    return sorted(name if "/" in name else f"{package}/{name}" for name in names)


def _message_file(name: str, suffix: str, shares: Sequence[Path]) -> Path:
    """Find ``<share>/<package>/msg/<Type><suffix>``."""
    package, type_name = name.split("/")[0], name.split("/")[-1]
    for share in shares:
        candidate = share / package / "msg" / f"{type_name}{suffix}"
        if candidate.is_file():
            return candidate
    where = os.pathsep.join(str(share) for share in shares) or "an empty AMENT_PREFIX_PATH"
    raise DefinitionError(f"no {type_name}{suffix} of package {package} in {where}")


@cache
def _type_hash(name: str, path: Path) -> str:
    """Read one type's hash from its type description file."""
    hashes = json.loads(path.read_text()).get("type_hashes", [])
    found = {each["type_name"]: each["hash_string"] for each in hashes}
    if name not in found:
        raise DefinitionError(f"{path} holds no type hash of {name}")
    return str(found[name])
