"""
The records that cross components: plain, frozen, without ROS.

Positions are NED (m), attitudes are unit quaternions body to NED, nu is the body velocity [u, v, w, p, q, r]
(m/s, rad/s, FRD).  `tick` counts control periods from the start of the scenario.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Quat, Vec3

Vec6 = tuple[float, float, float, float, float, float]


_LARGEST = 1e9


@dataclass(frozen=True, slots=True)
class VehicleState:
    """
    Pose and velocity of one vehicle at a tick: the truth, or what its own navigation believes.

    `is_valid` is false where the navigation has no solution; the numbers are then the last ones that it had.
    """

    tick: int
    position: Vec3
    attitude: Quat
    nu: Vec6
    is_valid: bool = True


def is_usable(state: VehicleState) -> bool:
    """Return whether `state` is valid and all its numbers are finite and of this world."""
    return state.is_valid and all(
        abs(number) <= _LARGEST for number in (*state.position, *state.attitude, *state.nu)
    )


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force and moment on the body, [X, Y, Z, K, M, N] (N, N m; body FRD, at the hull's centre)."""

    tau: Vec6


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """Velocity command of a kinematic vehicle: NED velocity (m/s) and yaw rate (rad/s)."""

    velocity: Vec3
    yaw_rate_radps: float


Command = Wrench | VelocityCommand


def command_numbers(command: Command) -> Vec6:
    """Return [X, Y, Z, K, M, N] (N, N m; body), or [NED velocity, 0, 0, yaw rate] (m/s, rad/s)."""
    if isinstance(command, Wrench):
        return command.tau
    return (*command.velocity, 0.0, 0.0, command.yaw_rate_radps)


@dataclass(frozen=True, slots=True)
class Packet:
    """What an agent hands to its modem. `destination` 0 means everybody; addresses count from 1."""

    tick: int
    source: int
    destination: int
    sequence: int
    payload: bytes


@dataclass(frozen=True, slots=True)
class Reception:
    """
    A packet that arrived: start of its transmission and end of its reception (s), SNR (dB; NaN where not
    modelled).
    """

    packet: Packet
    sent_s: float
    arrival_s: float
    snr_db: float


@dataclass(frozen=True, slots=True)
class Inbox:
    """
    What a modem tells its vehicle at a tick.

    `transmit_ready`: the modem asks for data; a packet handed over in this tick goes on the air before the
    next.
    """

    tick: int
    transmit_ready: bool
    receptions: tuple[Reception, ...]
