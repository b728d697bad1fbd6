"""Messages from a worker to its parent, which never waits for an incomplete one."""

from __future__ import annotations

import pickle
import socket
from collections.abc import Iterator
from typing import Any

_LENGTH_BYTES = 8
_CHUNK_BYTES = 1 << 20


def send(stream: socket.socket, message: Any) -> None:
    """Send a message; if it cannot be pickled, raise pickle's error and send nothing."""
    body = pickle.dumps(message)
    stream.sendall(len(body).to_bytes(_LENGTH_BYTES, "little") + body)


class Inbox:
    """The parent's end of the stream; reading never blocks."""

    def __init__(self, stream: socket.socket) -> None:
        self._stream = stream
        self._stream.setblocking(False)
        self._buffer = bytearray()

    def read(self) -> Iterator[Any]:
        """Yield the messages that are complete."""
        while chunk := self._chunk():
            self._buffer += chunk
        while len(self._buffer) >= _LENGTH_BYTES:
            end = _LENGTH_BYTES + int.from_bytes(self._buffer[:_LENGTH_BYTES], "little")
            if len(self._buffer) < end:
                return
            body = bytes(self._buffer[_LENGTH_BYTES:end])
            del self._buffer[:end]
            yield pickle.loads(body)  # noqa: S301  # a fork of this process wrote it

    def _chunk(self) -> bytes:
        try:
            return self._stream.recv(_CHUNK_BYTES)
        except (BlockingIOError, ConnectionResetError):
            return b""
