"""
Conversion between records and ROS messages: the only place that converts frames, quaternion order and stamps.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from functools import cache

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, TransformStamped, TwistStamped, Vector3
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from auv_core.cdr import COUNT, align, begun, put_text
from auv_core.geometry import Quat, Vec3
from auv_core.integrate import State
from auv_core.messages import Vec6, VehicleState
from auv_core.odom_frame import OdomFrame
from auv_msgs.msg import (
    ControlStatus,
    FlockingCentre,
    NeighbourEstimate,
    NeighbourEstimates,
)
from auv_msgs.msg import VehicleState as VehicleStateMsg
from auv_ros.wire.row_stencil import RowStencil
from auv_ros.wire.stencil import Stencil, read_numbers
from auv_ros.wire.transform_stencil import Pose, TransformStencil

WORLD_FRAME = "map_ned"
MAP_FRAME = "map"

_STATE = struct.Struct("<q??6x15d")
_TICK = struct.Struct("<q")
NEIGHBOUR_NUMBERS = 44
"""Numbers of one auv_msgs/NeighbourEstimate, its address left out."""
_HALF_SQRT = math.sqrt(0.5)
_DIAGONAL_OF_SIX = "48x".join("d" * 6)
"""The six diagonal numbers of a covariance of 36, with zeros between them."""


def body_frame(vehicle_id: str) -> str:
    """Return the frame id of a vehicle's body (forward, right, down)."""
    return f"{vehicle_id}/base_link_frd"


def base_frame(vehicle_id: str) -> str:
    """Return the frame id of a vehicle's body (forward, left, up) at the pose of its navigation."""
    return f"{vehicle_id}/base_link"


def odom_frame(vehicle_id: str) -> str:
    """Return the frame id of a vehicle's dead reckoning."""
    return f"{vehicle_id}/odom"


def truth_frame(vehicle_id: str) -> str:
    """Return the frame id of a vehicle's body (forward, left, up) at its true pose."""
    return f"{vehicle_id}/base_link_truth"


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
    return Stencil(VehicleStateMsg(header=header(0.0, WORLD_FRAME)), "q??6x15d")


def state_numbers(state: VehicleState) -> tuple[float, ...]:
    """
    Return tick, validity, whether the error is bounded, pose (NED; quaternion with w last), nu (body) and the
    navigation's standard deviations in the order of the message.
    """
    w, x, y, z = state.attitude
    sds = (state.position_sd_m, state.heading_sd_rad)
    flags = (state.is_valid, state.is_bounded)
    return (state.tick, *flags, *state.position, x, y, z, w, *state.nu, *sds)


def state_from_bytes(data: bytes) -> VehicleState:
    """Return the record of a serialised state message; raise `MalformedError` without one."""
    numbers = read_numbers(data, _STATE)
    tick, is_valid, is_bounded, *_ = numbers
    x, y, z, w = numbers[6:10]
    sds = numbers[16], numbers[17]
    return VehicleState(tick, numbers[3:6], (w, x, y, z), numbers[10:16], is_valid, *sds, is_bounded)


def enu_pose(position: Vec3, attitude: Quat) -> Pose:
    """
    Return a pose (m, NED; body FRD to NED) in the axes of REP-103: east-north-up, body forward-left-up,
    quaternion with w last.
    """
    w, x, y, z = attitude
    return (
        position[1],
        position[0],
        -position[2],
        _HALF_SQRT * (x + y),
        _HALF_SQRT * (x - y),
        _HALF_SQRT * (w - z),
        _HALF_SQRT * (w + z),
    )


def flu_velocity(nu: Vec6) -> Vec6:
    """Return a body velocity (m/s, rad/s; forward-right-down) in forward-left-up."""
    return (nu[0], -nu[1], -nu[2], nu[3], -nu[4], -nu[5])


def odometry_stencil(frame_id: str, child_frame_id: str) -> Stencil:
    """
    Return nav_msgs/Odometry; fill it with an `enu_pose`, the diagonal of its covariance (m^2, rad^2), an
    `flu_velocity`, and the diagonal of that one's covariance (m^2/s^2, rad^2/s^2).
    """
    message = Odometry(header=header(0.0, frame_id), child_frame_id=child_frame_id)
    return Stencil(message, f"7d{_DIAGONAL_OF_SIX}6d{_DIAGONAL_OF_SIX}")


def estimate_variances(state: VehicleState, depth_sd_m: float) -> Vec6:
    """
    Return the variances of an `enu_pose`: of east, north and up (m^2), roll, pitch and heading (rad^2).

    Roll and pitch are exact in every navigation of this project.
    """
    horizontal_m2 = state.position_sd_m * state.position_sd_m
    heading_rad2 = state.heading_sd_rad * state.heading_sd_rad
    return (horizontal_m2, horizontal_m2, depth_sd_m * depth_sd_m, 0.0, 0.0, heading_rad2)


def motion_transforms(vehicle_id: str) -> TransformStencil:
    """
    Return the message of a vehicle on /tf; fill it with the poses of odom in map, of the estimated body in
    odom, and of the true body in map.
    """
    return TransformStencil(
        [
            (MAP_FRAME, odom_frame(vehicle_id)),
            (odom_frame(vehicle_id), base_frame(vehicle_id)),
            (MAP_FRAME, truth_frame(vehicle_id)),
        ]
    )


def odom_in_map(frame: OdomFrame) -> Pose:
    """
    Return the transform map -> odom: map is east-north-up, and so is odom, rotated by the corrections so far.
    """
    half_rad = -0.5 * frame.turn_rad
    return (frame.east_m, frame.north_m, 0.0, 0.0, 0.0, math.sin(half_rad), math.cos(half_rad))


def base_to_frd(vehicle_id: str) -> TransformStamped:
    """Return the transform base_link -> base_link_frd: half a turn about the forward axis."""
    message = TransformStamped(
        header=header(0.0, base_frame(vehicle_id)), child_frame_id=body_frame(vehicle_id)
    )
    message.transform.rotation = quaternion((0.0, 1.0, 0.0, 0.0))
    return message


def map_to_map_ned() -> TransformStamped:
    """
    Return the transform map -> map_ned: east-north-up to north-east-down, half a turn about the north-east
    diagonal.
    """
    message = TransformStamped(header=header(0.0, MAP_FRAME), child_frame_id=WORLD_FRAME)
    message.transform.rotation = quaternion((0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0))
    return message


def velocity_stencil() -> Stencil:
    """Return a velocity (m/s; NED) and a yaw rate as geometry_msgs/TwistStamped."""
    return Stencil(TwistStamped(header=header(0.0, WORLD_FRAME)), "6d")


def clock_stencil() -> Stencil:
    """Return rosgraph_msgs/Clock; it has a stamp and no numbers."""
    return Stencil(Clock(), "")


def control_bytes(vehicle_id: str, t_s: float, tick: int, holding: str, law_state: State) -> bytes:
    """
    Return auv_msgs/ControlStatus at the time `t_s` (s): the state of a law, and why its agent holds, if it
    does.
    """
    size = len(law_state)
    if not holding:
        return _control_stencil(vehicle_id, size).filled(t_s, tick, 1, 0, size, *law_state)
    out = begun(body_frame(vehicle_id), t_s)
    out += _TICK.pack(tick)
    put_text(out, holding)
    align(out, COUNT.size)
    out += COUNT.pack(size)
    if size:
        align(out, 8)
        out += struct.pack(f"<{size}d", *law_state)
    return bytes(out)


@cache
def _control_stencil(vehicle_id: str, size: int) -> Stencil:
    """
    Return the status of an acting law with a state of `size` numbers.

    Fill it with the tick, length and end of an empty text (1 and 0), `size`, and the numbers.
    """
    message = ControlStatus(header=header(0.0, body_frame(vehicle_id)), law_state=[0.0] * size)
    return Stencil(message, f"qIB3xI4x{size}d")


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
    return RowStencil(bytes(serialize_message(message)), len(addresses), NEIGHBOUR_NUMBERS)


class NeighboursWriter:
    """Writes auv_msgs/NeighbourEstimates of neighbours that come and go."""

    def __init__(self) -> None:
        self._addresses: Sequence[int] = []
        self._stencil = neighbours_stencil([])

    def filled(self, t_s: float, tick: int, addresses: Sequence[int], rows: NDArray[np.float64]) -> bytes:
        """Return the message with a stamp (s), a tick and one row per address, see `neighbours_stencil`."""
        if addresses != self._addresses:
            self._addresses = addresses
            self._stencil = neighbours_stencil(addresses)
        return self._stencil.filled(t_s, tick, rows)
