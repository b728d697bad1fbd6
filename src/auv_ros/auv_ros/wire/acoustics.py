"""
Conversion of outboxes, inboxes, the acoustic log and link counters to and from serialised ROS messages.

Their lengths change from tick to tick, so a `Stencil` cannot be used. To build message objects field by
field and to serialise them takes ten times as long as to write the bytes. The layout is that of `cdr`, and a
test compares it with the serialisation of ROS.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from auv_core.cdr import COUNT, MOST_END_PADDING, MalformedError, align, aligned, begun, body_at
from auv_core.messages import AcousticEvent, Inbox, Packet, Reception, SonarContact
from auv_core.stamp import nanoseconds

_OUTBOX = struct.Struct("<qI")
_INBOX = struct.Struct("<q?3xI")
_QUIET_INBOX = struct.Struct("<q?3xII")
_PACKET = struct.Struct("<qBB2xII")
_THREE = struct.Struct("<3d")
_TIMES = struct.Struct("<iIiI")
_NUMBER = struct.Struct("<d")
_EVENT = struct.Struct("<BBBxIiIiI4xdI")
_SECOND_NS = 1_000_000_000
# Eleven limits and twelve classes of delay: with these numbers links follow each other without padding.
_DELAY_EDGES = struct.Struct("<I4x11dI")
_LINK = struct.Struct("<BB2x7I4xQI12I")


def outbox_bytes(frame_id: str, tick: int, packets: Sequence[Packet], t_s: float) -> bytes:
    """Return auv_msgs/AcousticOutbox: the packets of an agent for its modem at the time `t_s` (s)."""
    out = begun(frame_id, t_s)
    out += _OUTBOX.pack(tick, len(packets))
    for packet in packets:
        _put_packet(out, packet)
    return bytes(out)


def inbox_bytes(frame_id: str, inbox: Inbox, t_s: float, epoch_ns: int) -> bytes:
    """
    Return auv_msgs/AcousticInbox: the data of a modem for its vehicle at the time `t_s` (s).

    Scenario time 0 has the stamp `epoch_ns` (ns).
    """
    out = begun(frame_id, t_s)
    out += _INBOX.pack(inbox.tick, inbox.transmit_ready, len(inbox.receptions))
    for reception in inbox.receptions:
        _put_packet(out, reception.packet)
        align(out, 4)
        out += _TIMES.pack(*_times(reception.sent_s, reception.arrival_s, epoch_ns))
        align(out, 8)
        out += _NUMBER.pack(reception.snr_db)
    out += COUNT.pack(len(inbox.contacts))
    for contact in inbox.contacts:
        align(out, 8)
        out += _THREE.pack(contact.range_m, contact.bearing_rad, contact.elevation_rad)
    return bytes(out)


def events_bytes(tick: int, events: Sequence[AcousticEvent], t_s: float, epoch_ns: int) -> bytes:
    """
    Return auv_msgs/AcousticEvents: lines of the acoustic log of the tick at `t_s` (s).

    Scenario time 0 has the stamp `epoch_ns` (ns).
    """
    out = begun("", t_s)
    out += _OUTBOX.pack(tick, len(events))
    for e in events:
        times = _times(e.start_s, e.end_s, epoch_ns)
        out += _EVENT.pack(e.outcome, e.source, e.destination, e.sequence, *times, e.snr_db, e.size_bytes)
    return bytes(out)


def stats_bytes(
    delay_edges_s: Sequence[float], links: Sequence[tuple[Sequence[int], Sequence[int]]], t_s: float
) -> bytes:
    """
    Return auv_msgs/AcousticStats: the counters of all links at the time `t_s` (s).

    Parameters
    ----------
    delay_edges_s : sequence of eleven floats
        Limits between the classes of delay (s).
    links : sequence of (numbers, delay_counts)
        Per link the ten numbers of auv_msgs/AcousticLinkStats in their order, and its twelve counts.
    t_s : float
        Time of the count (s).

    """
    out = begun("", t_s)
    out += _DELAY_EDGES.pack(len(delay_edges_s), *delay_edges_s, len(links))
    for numbers, delay_counts in links:
        out += _LINK.pack(*numbers, len(delay_counts), *delay_counts)
    return bytes(out)


def read_outbox(data: bytes) -> tuple[int, list[Packet]]:
    """Return tick and packets of a serialised outbox; raise `MalformedError` for bytes that hold none."""
    reader = _Reader(data)
    tick, count = reader.take(_OUTBOX)
    packets = [reader.packet() for _ in range(count)]
    reader.end()
    return tick, packets


def read_inbox(data: bytes, epoch_ns: int) -> Inbox:
    """
    Return the record of a serialised inbox; raise `MalformedError` for bytes that hold none.

    Scenario time 0 has the stamp `epoch_ns` (ns).
    """
    at = body_at(data)
    if len(data) - at == _QUIET_INBOX.size:  # in most ticks nothing is received and nothing seen
        tick, is_ready, received, seen = _QUIET_INBOX.unpack_from(data, at)
        if not received and not seen:
            return Inbox(tick, is_ready, ())
    reader = _Reader(data)
    tick, is_ready, count = reader.take(_INBOX)
    receptions = tuple([reader.reception(epoch_ns) for _ in range(count)])
    (count,) = reader.take(COUNT, 4)
    contacts = tuple([SonarContact(*reader.take(_THREE, 8)) for _ in range(count)])
    reader.end()
    return Inbox(tick, is_ready, receptions, contacts)


class _Reader:
    """Reads one message from the end of its header on."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = body_at(data)

    def take(self, layout: struct.Struct, size: int = 8) -> tuple:
        at = aligned(self._at, size)
        self._at = at + layout.size
        try:
            return layout.unpack_from(self._data, at)
        except struct.error:
            raise MalformedError(f"message of {len(self._data)} bytes is too short") from None

    def packet(self) -> Packet:
        *heading, size = self.take(_PACKET)
        at, self._at = self._at, self._at + size
        if self._at > len(self._data):
            raise MalformedError(f"message of {len(self._data)} bytes is too short for its packet")
        return Packet._make((*heading, self._data[at : self._at]))

    def reception(self, epoch_ns: int) -> Reception:
        packet = self.packet()
        sent, sent_ns, arrival, arrival_ns = self.take(_TIMES, 4)
        return Reception(
            packet,
            (sent * _SECOND_NS + sent_ns - epoch_ns) * 1e-9,
            (arrival * _SECOND_NS + arrival_ns - epoch_ns) * 1e-9,
            *self.take(_NUMBER, 8),
        )

    def end(self) -> None:
        """Refuse a message with more than the padding of the network after its last field."""
        if len(self._data) - self._at > MOST_END_PADDING:
            raise MalformedError(f"message has {len(self._data)} bytes; expected {self._at}")


def _times(first_s: float, second_s: float, epoch_ns: int) -> tuple[int, ...]:
    """Return two scenario times as stamps: seconds and nanoseconds of each."""
    first, first_ns = divmod(epoch_ns + nanoseconds(first_s), _SECOND_NS)
    second, second_ns = divmod(epoch_ns + nanoseconds(second_s), _SECOND_NS)
    return first, first_ns, second, second_ns


def _put_packet(out: bytearray, packet: Packet) -> None:
    align(out, 8)
    payload = packet.payload
    out += _PACKET.pack(packet.tick, packet.source, packet.destination, packet.sequence, len(payload))
    out += payload
