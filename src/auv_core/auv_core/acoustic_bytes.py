"""
Outboxes, inboxes and the acoustic log as serialised ROS messages, and back.

Their lengths change from tick to tick, so they cannot be filled in as a `Stencil` is; but to build message
objects field by field, and to serialise them, costs ten times what writing the bytes does.  The layout is
that of little-endian CDR (numbers aligned to their size, counted behind the four bytes of the encapsulation),
and a test holds it equal to what ROS serialises.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache

from auv_core.messages import AcousticEvent, Inbox, Packet, Reception, SonarContact
from auv_core.stamp import stamp_bytes

_ENCAPSULATION = b"\x00\x01\x00\x00"
_STAMP = slice(4, 12)
_FRAME_AT = 16
_OUTBOX = struct.Struct("<qI")
_INBOX = struct.Struct("<q?3xI")
_QUIET_INBOX = struct.Struct("<q?3xII")
_PACKET = struct.Struct("<qBB2xII")
_COUNT = struct.Struct("<I")
_THREE = struct.Struct("<3d")
_EVENT = struct.Struct("<BBBxI4x3dI")


def outbox_bytes(frame_id: str, tick: int, packets: Sequence[Packet], t_s: float) -> bytes:
    """Return auv_msgs/AcousticOutbox: what an agent hands to its modem at the time `t_s` (s)."""
    out = _begun(frame_id, t_s)
    out += _OUTBOX.pack(tick, len(packets))
    for packet in packets:
        _put_packet(out, packet)
    return bytes(out)


def inbox_bytes(frame_id: str, inbox: Inbox, t_s: float) -> bytes:
    """Return auv_msgs/AcousticInbox: what a modem tells its vehicle at the time `t_s` (s)."""
    out = _begun(frame_id, t_s)
    out += _INBOX.pack(inbox.tick, inbox.transmit_ready, len(inbox.receptions))
    for reception in inbox.receptions:
        _put_packet(out, reception.packet)
        _align(out, 8)
        out += _THREE.pack(reception.sent_s, reception.arrival_s, reception.snr_db)
    _align(out, 4)
    out += _COUNT.pack(len(inbox.contacts))
    for contact in inbox.contacts:
        _align(out, 8)
        out += _THREE.pack(contact.range_m, contact.bearing_rad, contact.elevation_rad)
    return bytes(out)


def events_bytes(tick: int, events: Sequence[AcousticEvent], t_s: float) -> bytes:
    """Return auv_msgs/AcousticEvents: lines of the acoustic log of the tick at `t_s` (s)."""
    out = _begun("", t_s)
    out += _OUTBOX.pack(tick, len(events))
    for e in events:
        out += _EVENT.pack(
            e.outcome, e.source, e.destination, e.sequence, e.start_s, e.end_s, e.snr_db, e.size_bytes
        )
    return bytes(out)


def read_outbox(data: bytes) -> tuple[int, list[Packet]]:
    """Return tick and packets of a serialised outbox; raise ValueError for bytes that hold none."""
    reader = _Reader(data)
    tick, count = reader.take(_OUTBOX)
    return tick, [reader.packet() for _ in range(count)]


def read_inbox(data: bytes) -> Inbox:
    """Return the record of a serialised inbox; raise ValueError for bytes that hold none."""
    at = _body_at(data)
    if len(data) - at == _QUIET_INBOX.size:  # in most ticks nothing is received and nothing seen
        tick, is_ready, received, seen = _QUIET_INBOX.unpack_from(data, at)
        if not received and not seen:
            return Inbox(tick, is_ready, ())
    reader = _Reader(data)
    tick, is_ready, count = reader.take(_INBOX)
    receptions = tuple([Reception(reader.packet(), *reader.take(_THREE, 8)) for _ in range(count)])
    (count,) = reader.take(_COUNT, 4)
    return Inbox(
        tick, is_ready, receptions, tuple([SonarContact(*reader.take(_THREE, 8)) for _ in range(count)])
    )


def _body_at(data: bytes) -> int:
    """Return where a message goes on behind its header, with a number of eight bytes."""
    if data[: len(_ENCAPSULATION)] != _ENCAPSULATION or len(data) < _FRAME_AT:
        raise ValueError(f"{len(data)} bytes that are no message with a header in little-endian CDR")
    (length,) = _COUNT.unpack_from(data, _FRAME_AT - _COUNT.size)
    end: int = _FRAME_AT + length
    return end + -(end - len(_ENCAPSULATION)) % 8


class _Reader:
    """Reads one message from the end of its header on."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = _body_at(data)

    def take(self, layout: struct.Struct, size: int = 8) -> tuple:
        at = self._at + -(self._at - len(_ENCAPSULATION)) % size
        self._at = at + layout.size
        try:
            return layout.unpack_from(self._data, at)
        except struct.error:
            raise ValueError(f"{len(self._data)} bytes that are no such message: it goes on") from None

    def packet(self) -> Packet:
        tick, source, destination, sequence, size = self.take(_PACKET)
        at, self._at = self._at, self._at + size
        if self._at > len(self._data):
            raise ValueError(f"{len(self._data)} bytes that are no such message: a packet goes on")
        return Packet(tick, source, destination, sequence, self._data[at : self._at])


def _begun(frame_id: str, t_s: float) -> bytearray:
    """Return a message as far as its header, ready for a number of eight bytes."""
    out = bytearray(_header(frame_id))
    out[_STAMP] = stamp_bytes(t_s)
    return out


@cache
def _header(frame_id: str) -> bytes:
    name = frame_id.encode() + b"\0"
    out = bytearray(_ENCAPSULATION + bytes(8) + _COUNT.pack(len(name)) + name)
    _align(out, 8)
    return bytes(out)


def _put_packet(out: bytearray, packet: Packet) -> None:
    _align(out, 8)
    payload = packet.payload
    out += _PACKET.pack(packet.tick, packet.source, packet.destination, packet.sequence, len(payload))
    out += payload


def _align(out: bytearray, size: int) -> None:
    out += bytes(-(len(out) - len(_ENCAPSULATION)) % size)
