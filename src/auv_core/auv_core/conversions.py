"""
Records to ROS messages and back: the one place where frames, quaternion order and stamps are translated.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from functools import cache

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, TwistStamped, Vector3, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from auv_core.geometry import Quat, Vec3
from auv_core.integrate import State
from auv_core.messages import (
    Command,
    VehicleState,
    VelocityCommand,
    Wrench,
)
from auv_core.row_stencil import RowStencil
from auv_core.stencil import Stencil, read_numbers
from auv_msgs.msg import (
    ControlStatus,
    FlockingCentre,
    NeighbourEstimate,
    NeighbourEstimates,
)
from auv_msgs.msg import VehicleState as VehicleStateMsg

WORLD_FRAME = "map_ned"

_STATE = struct.Struct("<q?7x15d")
_SIX = struct.Struct("<6d")
_NEIGHBOUR_NUMBERS = 44


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
    """Return the record of a serialised state message; raise `MalformedError` without one."""
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


def neighbours_stencil(addresses: Sequence[int]) -> RowStencil:
    """
    Return auv_msgs/NeighbourEstimates of neighbours; fill it with tick and, in rows, position (m; NED),
    velocity (m/s; NED), covariance, and the ages of packet and contact (s).
    """
    message = NeighbourEstimates(
        header=header(0.0, WORLD_FRAME), neighbours=[NeighbourEstimate(address=k) for k in addresses]
    )
    return RowStencil(bytes(serialize_message(message)), len(addresses), _NEIGHBOUR_NUMBERS)
