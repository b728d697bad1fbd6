"""
Records to ROS messages and back: the one place where frames, quaternion order and stamps are translated.
"""

from __future__ import annotations

import math

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, TwistStamped, Vector3, WrenchStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from auv_core.geometry import Quat, Vec3
from auv_core.messages import Command, Inbox, Packet, Reception, VehicleState, VelocityCommand, Wrench
from auv_msgs.msg import AcousticInbox, AcousticOutbox, AcousticPacket, AcousticReception
from auv_msgs.msg import VehicleState as VehicleStateMsg

WORLD_FRAME = "map_ned"


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


def state_to_msg(state: VehicleState, t_s: float) -> VehicleStateMsg:
    """Return a vehicle's pose (NED) and nu (body) as the small state message."""
    message = VehicleStateMsg(header=header(t_s, WORLD_FRAME), tick=state.tick)
    message.pose.position = point(state.position)
    message.pose.orientation = quaternion(state.attitude)
    message.twist.linear = vector(state.nu[:3])
    message.twist.angular = vector(state.nu[3:])
    return message


def state_from_msg(message: VehicleStateMsg) -> VehicleState:
    """Return the record of a state message."""
    p, q = message.pose.position, message.pose.orientation
    v, w = message.twist.linear, message.twist.angular
    return VehicleState(message.tick, (p.x, p.y, p.z), (q.w, q.x, q.y, q.z), (v.x, v.y, v.z, w.x, w.y, w.z))


def state_to_odometry(state: VehicleState, t_s: float, vehicle_id: str) -> Odometry:
    """Return the same as nav_msgs/Odometry: pose in map_ned, twist in the body frame, no covariance."""
    message = Odometry(header=header(t_s, WORLD_FRAME), child_frame_id=body_frame(vehicle_id))
    message.pose.pose.position = point(state.position)
    message.pose.pose.orientation = quaternion(state.attitude)
    message.twist.twist.linear = vector(state.nu[:3])
    message.twist.twist.angular = vector(state.nu[3:])
    return message


def state_to_transform(state: VehicleState, t_s: float, vehicle_id: str) -> TransformStamped:
    """Return the transform map_ned -> body of a vehicle."""
    message = TransformStamped(header=header(t_s, WORLD_FRAME), child_frame_id=body_frame(vehicle_id))
    message.transform.translation = vector(state.position)
    message.transform.rotation = quaternion(state.attitude)
    return message


def map_to_map_ned() -> TransformStamped:
    """
    Return the transform map -> map_ned: east-north-up to north-east-down, half a turn about the north-east
    diagonal.
    """
    message = TransformStamped(header=header(0.0, "map"), child_frame_id=WORLD_FRAME)
    message.transform.rotation = quaternion((0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0))
    return message


def command_to_msg(command: Command, t_s: float, vehicle_id: str) -> WrenchStamped | TwistStamped:
    """Return a wrench in the body frame, or a velocity command in map_ned."""
    if isinstance(command, Wrench):
        wrench = WrenchStamped(header=header(t_s, body_frame(vehicle_id)))
        wrench.wrench.force = vector(command.tau[:3])
        wrench.wrench.torque = vector(command.tau[3:])
        return wrench
    return velocity_msg(command.velocity, command.yaw_rate_radps, t_s)


def velocity_msg(velocity: Vec3, yaw_rate_radps: float, t_s: float) -> TwistStamped:
    """Return a velocity (m/s; NED) and a yaw rate as a message."""
    twist = TwistStamped(header=header(t_s, WORLD_FRAME))
    twist.twist.linear = vector(velocity)
    twist.twist.angular.z = yaw_rate_radps
    return twist


def command_from_msg(message: WrenchStamped | TwistStamped) -> Command:
    """Return the record of a command message; raise ValueError when a number in it is not finite."""
    if isinstance(message, WrenchStamped):
        f, m = message.wrench.force, message.wrench.torque
        values = (f.x, f.y, f.z, m.x, m.y, m.z)
        command: Command = Wrench(values)
    else:
        v = message.twist.linear
        values = (v.x, v.y, v.z, 0.0, 0.0, message.twist.angular.z)
        command = VelocityCommand((v.x, v.y, v.z), message.twist.angular.z)
    if not all(map(math.isfinite, values)):
        raise ValueError(f"a command with a number that is not finite: {values}")
    return command


def stamp_s(time: Time) -> float:
    """Return a ROS stamp in seconds."""
    return float(time.sec) + 1e-9 * float(time.nanosec)


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
    )


def inbox_from_msg(message: AcousticInbox) -> Inbox:
    """Return the record of an inbox message."""
    receptions = tuple(
        Reception(packet_from_msg(r.packet), r.sent_s, r.arrival_s, r.snr_db) for r in message.receptions
    )
    return Inbox(message.tick, message.transmit_ready, receptions)
