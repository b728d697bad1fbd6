"""Every message of auv_msgs, from the comments of its file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from from_code.markdown import code, table

_CONSTANT = re.compile(r"^(\S+) ([A-Z_0-9]+)=(.*)$")
_FIELD = re.compile(r"^(\S+) ([a-z_0-9]+)\s*(?:#\s*(.*))?$")


class Message(NamedTuple):
    """What the file of a message says."""

    name: str
    words: str
    constants: list[tuple[str, str, str]]
    """Name, value and meaning."""
    fields: list[tuple[str, str, str]]
    """Name, type and meaning."""


def read_message(path: Path) -> Message:
    """Return what the file of a message says; raise ValueError at a line that is none of its language."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = _comment(lines)
    constants, fields = [], []
    waiting: list[str] = []
    for line in lines[len(head) :]:
        if line.startswith("#"):
            waiting.append(line.lstrip("# "))
        elif found := _CONSTANT.match(line):
            constants.append((found[2], found[3], " ".join(waiting)))
            waiting = []
        elif found := _FIELD.match(line):
            fields.append((found[2], found[1], found[3] or ""))
        elif line.strip():
            raise ValueError(f"{path.name}: {line!r} is neither a field nor a constant")
    return Message(path.stem, " ".join(line.lstrip("# ") for line in head), constants, fields)


def _comment(lines: list[str]) -> list[str]:
    """Return the lines of the comment at the top of a file."""
    end = next((number for number, line in enumerate(lines) if not line.startswith("#")), len(lines))
    return lines[:end]


def messages(folder: Path) -> str:
    """Return all messages of a folder."""
    return "\n".join(_part(read_message(path)) for path in sorted(folder.glob("*.msg")))


def _part(message: Message) -> str:
    parts = [f"## {message.name} {{ #{message.name.lower()} }}\n", message.words + "\n"]
    if message.constants:
        rows = [(code(name), code(value), words) for name, value, words in message.constants]
        parts.append(table(("constant", "value", "meaning"), rows))
    rows = [(code(name), code(kind), words) for name, kind, words in message.fields]
    parts.append(table(("field", "type", "meaning"), rows))
    return "\n".join(parts)
