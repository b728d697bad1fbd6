"""
The records that components exchange: without ROS, and tuples, since many are made in every tick.

Positions are NED (m), attitudes are unit quaternions body to NED, nu is the body velocity [u, v, w, p, q, r]
(m/s, rad/s, FRD).  `tick` counts control periods from the start of the scenario.
"""

from __future__ import annotations

import enum
from typing import NamedTuple

from auv_core.geometry import Quat, Vec3

Vec6 = tuple[float, float, float, float, float, float]
Numbers = tuple[float, ...]


class VehicleState(NamedTuple):
    """
    Pose and velocity of one vehicle at a tick: the truth, or the estimate of its own navigation.

    `is_valid` is false if the navigation has no solution; the numbers are then its last ones. `position_sd_m`
    (per horizontal axis, m) and `heading_sd_rad` are the navigation's own standard deviations; the truth has
    none. `is_bounded`: its error does not grow without limit, because position fixes come again and again, or
    since it has none.
    """

    tick: int
    position: Vec3
    attitude: Quat
    nu: Vec6
    is_valid: bool = True
    position_sd_m: float = 0.0
    heading_sd_rad: float = 0.0
    is_bounded: bool = False

    @property
    def numbers(self) -> Numbers:
        """The 13 numbers of a hull's state: position, attitude and nu."""
        return self.position + self.attitude + self.nu


class Wrench(NamedTuple):
    """Force and moment on the body, [X, Y, Z, K, M, N] (N, N m; body FRD, at the hull's centre)."""

    tau: Vec6


class VelocityCommand(NamedTuple):
    """Velocity command of a kinematic vehicle: NED velocity (m/s) and yaw rate (rad/s)."""

    velocity: Vec3
    yaw_rate_radps: float


class FinCommand(NamedTuple):
    """
    Command of a torpedo: angles of rudder and stern plane (rad), and the propeller's speed (rpm).

    A positive rudder turns to starboard, a positive stern plane lowers the nose.
    """

    rudder_rad: float
    stern_plane_rad: float
    propeller_rpm: float


class ThrusterCommand(NamedTuple):
    """Forces of the thrusters, each along its own direction (N), in the order of the vehicle's thrusters."""

    forces_n: Numbers


Command = Wrench | VelocityCommand | FinCommand | ThrusterCommand
COMMANDS = ("wrench", "velocity", "fins", "thrusters")
"""The kinds of commands: what a vehicle takes and what a controller gives."""


def command_numbers(command: Command) -> Numbers:
    """
    Return the numbers of a command.

    Returns
    -------
    numbers : tuple of float
        [X, Y, Z, K, M, N] (N, N m; body), [NED velocity, 0, 0, yaw rate] (m/s, rad/s), [rudder, stern plane,
        propeller] (rad, rad, rpm), or the forces of the thrusters (N).

    """
    if isinstance(command, Wrench):
        return command.tau
    if isinstance(command, VelocityCommand):
        return (*command.velocity, 0.0, 0.0, command.yaw_rate_radps)
    if isinstance(command, FinCommand):
        return tuple(command)
    return command.forces_n


def command_of(kind: str, numbers: Numbers) -> Command:
    """Return the command of a kind with these numbers; the inverse of `command_numbers`."""
    if kind == "wrench":
        (x, y, z), (k, m, n) = numbers[:3], numbers[3:]
        return Wrench((x, y, z, k, m, n))
    if kind == "velocity":
        north, east, down = numbers[:3]
        return VelocityCommand((north, east, down), numbers[5])
    if kind == "fins":
        return FinCommand(*numbers)
    return ThrusterCommand(numbers)


class Packet(NamedTuple):
    """
    A packet that an agent passes to its modem. `destination` 0 means all vehicles; addresses count from 1.
    """

    tick: int
    source: int
    destination: int
    sequence: int
    payload: bytes


class Reception(NamedTuple):
    """
    A packet that arrived: start of its transmission and end of its reception (s), SNR (dB; NaN if not
    modelled).
    """

    packet: Packet
    sent_s: float
    arrival_s: float
    snr_db: float


class SonarContact(NamedTuple):
    """
    An unidentified object that the sonar saw at a tick.

    Range (m); bearing (rad) from the body's forward axis towards starboard, atan2(y, x) in the body frame
    FRD; elevation (rad) above the body's horizontal plane, atan2(-z, hypot(x, y)).
    """

    range_m: float
    bearing_rad: float
    elevation_rad: float


class Inbox(NamedTuple):
    """
    Data from modem and sonar for their vehicle at a tick.

    `transmit_ready`: the modem asks for data; a packet passed to it in this tick is transmitted next.
    `contacts`: the sonar contacts of this tick.
    """

    tick: int
    transmit_ready: bool
    receptions: tuple[Reception, ...]
    contacts: tuple[SonarContact, ...] = ()


class Outcome(enum.IntEnum):
    """Outcome of a packet: sent, or at one receiver delivered, or lost and why."""

    SENT = 0
    DELIVERED = 1
    RANGE = 2
    NOISE = 3
    COLLISION = 4
    HALF_DUPLEX = 5
    OUTAGE = 6


class AcousticEvent(NamedTuple):
    """
    One line of the acoustic log.

    SENT is logged once per transmission, with the packet's destination (0: all vehicles), from its first to
    its last moment on the air. The other outcomes are logged once per packet and receiver, from the first to
    the last moment of the signal at the receiver. `snr_db` is NaN if it is not modelled.
    """

    outcome: Outcome
    source: int
    destination: int
    sequence: int
    start_s: float
    end_s: float
    snr_db: float
    size_bytes: int
