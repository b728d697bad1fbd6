"""The logger of a log line, read from its bytes: most lines of a graph do not belong to the run."""

from __future__ import annotations

from auv_core.cdr import STAMP, read_text

_LEVEL_BYTES = 4
"""One byte, and the padding before the length of the next text."""
_LOGGER_AT = STAMP.stop + _LEVEL_BYTES


def logger_of(line: bytes) -> str:
    """Return the name of the logger in a serialised rcl_interfaces/Log."""
    return read_text(line, _LOGGER_AT)
