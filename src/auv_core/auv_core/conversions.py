"""
Records to ROS messages and back: the one place where frames, quaternion order and stamps are translated.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, TwistStamped, Vector3, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from auv_core.geometry import Quat, Vec3
from auv_core.integrate import State
from auv_core.messages import (
    AcousticEvent,
    Command,
    Inbox,
    Packet,
    Reception,
    SonarContact,
    VehicleState,
    VelocityCommand,
    Wrench,
)
from auv_core.stencil import Stencil, content_at, read_numbers
from auv_msgs.msg import AcousticEvent as AcousticEventMsg
from auv_msgs.msg import (
    AcousticEvents,
    AcousticInbox,
    AcousticOutbox,
    AcousticPacket,
    AcousticReception,
    ControlStatus,
    FlockingCentre,
    NeighbourEstimate,
    NeighbourEstimates,
)
from auv_msgs.msg import SonarContact as SonarContactMsg
from auv_msgs.msg import VehicleState as VehicleStateMsg

WORLD_FRAME = "map_ned"

_STATE = struct.Struct("<q?7x15d")
_SIX = struct.Struct("<6d")
_EMPTY_INBOX = struct.Struct("<q?3xII")
_EMPTY_OUTBOX = struct.Struct("<qI")


def body_frame(vehicle_id: str) -> str:
    """Return the frame id of a vehicle's body (forward, right, down)."""
    return f"{vehicle_id}/base_link_frd"


def stamp(t_s: float) -> Time:
    """Return a time (s) as a ROS stamp, to the nanosecond."""
    nanoseconds = round(t_s * 1e9)
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def header(t_s: float, frame_id: str) -> Header:
    """Return a header for a time (s) and a frame."""
    return Header(stamp=stamp(t_s), frame_id=frame_id)


def point(v: Vec3) -> Point:
    """Return a position as a message."""
    return Point(x=v[0], y=v[1], z=v[2])


def vector(v: Vec3) -> Vector3:
    """Return a free vector as a message."""
    return Vector3(x=v[0], y=v[1], z=v[2])


def quaternion(q: Quat) -> Quaternion:
    """Return (w, x, y, z) as a message, which has w last."""
    return Quaternion(x=q[1], y=q[2], z=q[3], w=q[0])


def state_stencil() -> Stencil:
    """Return the small state message; fill it with `state_numbers`."""
    return Stencil(VehicleStateMsg(header=header(0.0, WORLD_FRAME)), "q?7x15d")


def state_numbers(state: VehicleState) -> tuple[float, ...]:
    """
    Return tick, validity, pose (NED; quaternion with w last), nu (body) and the navigation's standard
    deviations in the order of the message.
    """
    w, x, y, z = state.attitude
    sds = (state.position_sd_m, state.heading_sd_rad)
    return (state.tick, state.is_valid, *state.position, x, y, z, w, *state.nu, *sds)


def state_from_bytes(data: bytes) -> VehicleState:
    """Return the record of a serialised state message; raise ValueError for bytes that hold none."""
    tick, is_valid, px, py, pz, x, y, z, w, *nu, position_sd_m, heading_sd_rad = read_numbers(data, _STATE)
    six = (nu[0], nu[1], nu[2], nu[3], nu[4], nu[5])
    return VehicleState(tick, (px, py, pz), (w, x, y, z), six, is_valid, position_sd_m, heading_sd_rad)


def odometry_stencil(vehicle_id: str) -> Stencil:
    """
    Return nav_msgs/Odometry, pose in map_ned, twist in the body frame; fill it with both of `state_numbers`.

    The truth has no covariance.
    """
    message = Odometry(header=header(0.0, WORLD_FRAME), child_frame_id=body_frame(vehicle_id))
    return Stencil(message, "7d288x6d288x")


def transform_stencil(vehicle_id: str) -> Stencil:
    """Return the transform map_ned -> body of a vehicle; fill it with the pose of `state_numbers`."""
    message = TransformStamped(header=header(0.0, WORLD_FRAME), child_frame_id=body_frame(vehicle_id))
    return Stencil(TFMessage(transforms=[message]), "7d", stamp_at=8)


def map_to_map_ned() -> TransformStamped:
    """
    Return the transform map -> map_ned: east-north-up to north-east-down, half a turn about the north-east
    diagonal.
    """
    message = TransformStamped(header=header(0.0, "map"), child_frame_id=WORLD_FRAME)
    message.transform.rotation = quaternion((0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0))
    return message


def command_stencil(vehicle_id: str, *, takes_velocity: bool) -> Stencil:
    """Return the command message of a vehicle, a wrench in the body frame or a velocity in map_ned."""
    if takes_velocity:
        return velocity_stencil()
    return Stencil(WrenchStamped(header=header(0.0, body_frame(vehicle_id))), "6d")


def velocity_stencil() -> Stencil:
    """Return a velocity (m/s; NED) and a yaw rate as geometry_msgs/TwistStamped."""
    return Stencil(TwistStamped(header=header(0.0, WORLD_FRAME)), "6d")


def command_from_bytes(data: bytes, *, takes_velocity: bool) -> Command:
    """Return the record of a serialised command; raise ValueError when a number in it is not finite."""
    x, y, z, k, m, n = values = read_numbers(data, _SIX)
    if not all(map(math.isfinite, values)):
        raise ValueError(f"a command with a number that is not finite: {values}")
    return VelocityCommand((x, y, z), n) if takes_velocity else Wrench((x, y, z, k, m, n))


def clock_stencil() -> Stencil:
    """Return rosgraph_msgs/Clock; it has a stamp and no numbers."""
    return Stencil(Clock(), "")


@cache
def control_stencil(vehicle_id: str, size: int) -> Stencil:
    """
    Return auv_msgs/ControlStatus of a law that acts and remembers `size` numbers: tick, 1, 0, size, numbers.
    """
    message = control_status(0, 0.0, vehicle_id, "", (0.0,) * size)
    return Stencil(message, f"qIB3xI4x{size}d")


def control_status(tick: int, t_s: float, vehicle_id: str, holding: str, law_state: State) -> ControlStatus:
    """Return what a law remembers and why its agent holds, if it does."""
    return ControlStatus(
        header=header(t_s, body_frame(vehicle_id)), tick=tick, holding=holding, law_state=list(law_state)
    )


def centre_stencil() -> Stencil:
    """Return auv_msgs/FlockingCentre; fill it with tick, position (m; NED) and velocity (m/s; NED)."""
    return Stencil(FlockingCentre(header=header(0.0, WORLD_FRAME)), "q6d")


@cache
def neighbours_stencil(count: int) -> Stencil:
    """
    Return auv_msgs/NeighbourEstimates with `count` neighbours: tick, count, then per neighbour 45 numbers.
    """
    message = NeighbourEstimates(
        header=header(0.0, WORLD_FRAME), neighbours=[NeighbourEstimate() for _ in range(count)]
    )
    layouts = ["B3x44d" if index == 0 else "B7x44d" for index in range(count)]
    return Stencil(message, "qI" + "".join(layouts))


def packet_to_msg(packet: Packet) -> AcousticPacket:
    """Return a packet as a message."""
    return AcousticPacket(
        tick=packet.tick,
        source=packet.source,
        destination=packet.destination,
        sequence=packet.sequence,
        payload=np.frombuffer(packet.payload, dtype=np.uint8),
    )


def packet_from_msg(message: AcousticPacket) -> Packet:
    """Return the record of a packet message."""
    return Packet(message.tick, message.source, message.destination, message.sequence, bytes(message.payload))


def outbox_maker(vehicle_id: str) -> Callable[[int, list[Packet], float], bytes]:
    """Return the function that makes the bytes of an outbox message, of the usual empty one quickly."""
    stencil = Stencil(outbox_to_msg(0, [], 0.0, vehicle_id), "qI")

    def make(tick: int, packets: list[Packet], t_s: float) -> bytes:
        if not packets:
            return stencil.filled(t_s, tick, 0)
        return bytes(serialize_message(outbox_to_msg(tick, packets, t_s, vehicle_id)))

    return make


def inbox_maker(vehicle_id: str) -> Callable[[Inbox, float], bytes]:
    """Return the function that makes the bytes of an inbox message, of the usual empty one quickly."""
    stencil = Stencil(inbox_to_msg(Inbox(0, False, (), ()), 0.0, vehicle_id), "q?3xII")

    def make(inbox: Inbox, t_s: float) -> bytes:
        if inbox.receptions or inbox.contacts:
            return bytes(serialize_message(inbox_to_msg(inbox, t_s, vehicle_id)))
        return stencil.filled(t_s, inbox.tick, inbox.transmit_ready, 0, 0)

    return make


def inbox_from_bytes(data: bytes) -> Inbox:
    """Return the record of a serialised inbox message; raise ValueError for bytes that hold none."""
    at = content_at(data)
    if len(data) == at + _EMPTY_INBOX.size:
        tick, is_ready, _, _ = _EMPTY_INBOX.unpack_from(data, at)
        return Inbox(tick, is_ready, (), ())
    return inbox_from_msg(_deserialised(data, AcousticInbox))


def outbox_from_bytes(data: bytes) -> tuple[int, list[Packet]]:
    """Return tick and packets of a serialised outbox message; raise ValueError for bytes that hold none."""
    at = content_at(data)
    if len(data) == at + _EMPTY_OUTBOX.size:
        return _EMPTY_OUTBOX.unpack_from(data, at)[0], []
    message = _deserialised(data, AcousticOutbox)
    return message.tick, [packet_from_msg(packet) for packet in message.packets]


def _deserialised(data: bytes, kind: Any) -> Any:
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # rclpy's own, without a class of their own
        raise ValueError(f"{len(data)} bytes that are no {kind.__name__}: {error}") from None


def outbox_to_msg(tick: int, packets: list[Packet], t_s: float, vehicle_id: str) -> AcousticOutbox:
    """Return what an agent hands to its modem in a tick."""
    return AcousticOutbox(
        header=header(t_s, body_frame(vehicle_id)),
        tick=tick,
        packets=[packet_to_msg(packet) for packet in packets],
    )


def inbox_to_msg(inbox: Inbox, t_s: float, vehicle_id: str) -> AcousticInbox:
    """Return what a modem tells its vehicle at a tick."""
    receptions = [
        AcousticReception(
            packet=packet_to_msg(r.packet), sent_s=r.sent_s, arrival_s=r.arrival_s, snr_db=r.snr_db
        )
        for r in inbox.receptions
    ]
    return AcousticInbox(
        header=header(t_s, body_frame(vehicle_id)),
        tick=inbox.tick,
        transmit_ready=inbox.transmit_ready,
        receptions=receptions,
        contacts=[
            SonarContactMsg(range_m=c.range_m, bearing_rad=c.bearing_rad, elevation_rad=c.elevation_rad)
            for c in inbox.contacts
        ],
    )


def inbox_from_msg(message: AcousticInbox) -> Inbox:
    """Return the record of an inbox message."""
    receptions = tuple(
        Reception(packet_from_msg(r.packet), r.sent_s, r.arrival_s, r.snr_db) for r in message.receptions
    )
    contacts = tuple(SonarContact(c.range_m, c.bearing_rad, c.elevation_rad) for c in message.contacts)
    return Inbox(message.tick, message.transmit_ready, receptions, contacts)


def events_to_msg(tick: int, events: list[AcousticEvent], t_s: float) -> AcousticEvents:
    """Return lines of the acoustic log as a message."""
    lines = [
        AcousticEventMsg(
            outcome=int(event.outcome),
            source=event.source,
            destination=event.destination,
            sequence=event.sequence,
            start_s=event.start_s,
            end_s=event.end_s,
            snr_db=event.snr_db,
            size_bytes=event.size_bytes,
        )
        for event in events
    ]
    return AcousticEvents(header=header(t_s, ""), tick=tick, events=lines)
