"""Commands and outputs of actuators as serialised ROS messages, one topic per kind of command."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

from geometry_msgs.msg import TwistStamped, WrenchStamped

from auv_core.cdr import COUNT, MOST_END_PADDING, MalformedError, aligned, header_end
from auv_core.messages import Command, Numbers, command_of
from auv_core.models import Actuator
from auv_core.state_checks import LARGEST, is_command
from auv_msgs.msg import ActuatorStates, FinCommand, ThrusterCommand
from auv_ros.wire.conversions import body_frame, header, velocity_stencil
from auv_ros.wire.stencil import Stencil, read_numbers

_SIX = struct.Struct("<6d")
_LAYOUTS = {"wrench": _SIX, "velocity": _SIX, "fins": struct.Struct("<3d")}
_MOST_THRUSTERS = 64


def command_topic(kind: str) -> tuple[Any, str]:
    """Return type and name of the topic of a vehicle that takes a kind of command."""
    return {
        "wrench": (WrenchStamped, "cmd_wrench"),
        "velocity": (TwistStamped, "cmd_vel"),
        "fins": (FinCommand, "cmd_fins"),
        "thrusters": (ThrusterCommand, "cmd_thrusters"),
    }[kind]


def command_bytes(vehicle_id: str, kind: str, t_s: float, *numbers: float) -> bytes:
    """
    Return the command message of a vehicle.

    Parameters
    ----------
    vehicle_id, kind : str
        Name of the vehicle, and the kind of command that it takes.
    t_s : float
        Time of the tick (s).
    numbers : float
        As `auv_core.messages.command_numbers` gives them.

    """
    return _stencil(vehicle_id, kind, len(numbers)).filled(t_s, *numbers)


@cache
def _stencil(vehicle_id: str, kind: str, size: int) -> Stencil:
    """Return the command message with `size` numbers: a velocity in map_ned, or else in the body frame."""
    if kind == "velocity":
        return velocity_stencil()
    message, _ = command_topic(kind)
    own = {"forces_n": [0.0] * size} if kind == "thrusters" else {}
    return Stencil(message(header=header(0.0, body_frame(vehicle_id)), **own), f"{size}d")


def command_from_bytes(data: bytes, kind: str, size: int) -> Command:
    """
    Return the record of a serialised command with `size` numbers.

    Raises
    ------
    ValueError
        If a number in it is not plausible, or it has another number of forces.
    MalformedError
        If the bytes are no command of that kind.

    """
    numbers = _forces_n(data) if kind == "thrusters" else read_numbers(data, _LAYOUTS[kind])
    if len(numbers) != size:
        raise ValueError(f"a command with {len(numbers)} forces; expected {size}, one for each thruster")
    if not is_command(numbers):
        raise ValueError(f"a command with a number that is not finite, or beyond {LARGEST:g}: {numbers}")
    return command_of(kind, numbers)


def _forces_n(data: bytes) -> Numbers:
    """Return the forces of auv_msgs/ThrusterCommand (N)."""
    at = aligned(header_end(data), COUNT.size)
    if len(data) < at + COUNT.size:
        raise MalformedError(f"message has {len(data)} bytes; expected at least {at + COUNT.size}")
    (count,) = COUNT.unpack_from(data, at)
    at = aligned(at + COUNT.size, 8)
    if not 1 <= count <= _MOST_THRUSTERS or not 0 <= len(data) - at - 8 * count <= MOST_END_PADDING:
        raise MalformedError(f"message has {len(data)} bytes, which are not the forces of {count} thrusters")
    return struct.unpack_from(f"<{count}d", data, at)


def actuators_stencil(vehicle_id: str, actuators: Sequence[Actuator]) -> Stencil:
    """Return auv_msgs/ActuatorStates; fill it with one output per actuator, each in its unit."""
    message = ActuatorStates(
        header=header(0.0, body_frame(vehicle_id)),
        names=[each.name for each in actuators],
        units=[each.unit for each in actuators],
        outputs=[0.0] * len(actuators),
    )
    return Stencil(message, f"{len(actuators)}d")
