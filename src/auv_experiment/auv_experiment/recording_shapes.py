"""The shapes of a recording's arrays, and their memory."""

from __future__ import annotations

import math

import numpy as np

_NUMBER_BYTES = 8
NEIGHBOURS = (
    "neighbour_position_ned_m",
    "neighbour_velocity_ned_mps",
    "neighbour_covariance",
    "neighbour_age_s",
    "neighbour_sonar_age_s",
)


def shapes_of(n_states: int, n: int) -> dict[str, tuple[int | None, ...]]:
    """Return the expected shape of every array; None means any number of rows."""
    k = n_states - 1
    return {
        "t_s": (n_states,),
        "position_ned_m": (n_states, n, 3),
        "attitude_quat_wxyz": (n_states, n, 4),
        "velocity_body": (n_states, n, 6),
        "command": (k, n, 6),
        "actuator_command": (k, n, None),
        "actuator_output": (n_states, n, None),
        "reference_velocity_ned_mps": (k, n, 3),
        "centre_ned_m": (k, n, 3),
        "centre_velocity_ned_mps": (k, n, 3),
        "law_state": (k, n, None),
        "holding": (k, n),
        "neighbour_position_ned_m": (k, n, n, 3),
        "neighbour_velocity_ned_mps": (k, n, n, 3),
        "neighbour_covariance": (k, n, n, 6, 6),
        "neighbour_age_s": (k, n, n),
        "neighbour_sonar_age_s": (k, n, n),
        "nav_position_ned_m": (k, n, 3),
        "nav_position_sd_m": (k, n),
        "contacts": (None, 2),
        "contact_values": (None, 3),
        "sent": (None, 3),
        "received": (None, 4),
        "delay_s": (None,),
        "events": (None, 6),
        "event_values": (None, 3),
        "lost_at_s": (n,),
    }


def dtype_of(name: str) -> type[np.int64] | type[np.float64]:
    """Return the type of an array's numbers."""
    return np.int64 if name in ("sent", "received", "contacts", "events", "holding") else np.float64


def _count(shape: tuple[int | None, ...]) -> int:
    return math.prod(size or 0 for size in shape)


def fits(shape: tuple[int, ...], expected: tuple[int | None, ...]) -> bool:
    """Return whether a shape is the expected one."""
    pairs = zip(shape, expected, strict=False)
    return len(shape) == len(expected) and all(want is None or size == want for size, want in pairs)


def bytes_per_tick(n_vehicles: int, *, has_neighbours: bool, n_actuators: int = 0) -> int:
    """
    Return the growth of a recording without packets per tick (bytes).

    Parameters
    ----------
    n_vehicles, n_actuators : int
        Number of vehicles, and the largest number of actuators of one of them.
    has_neighbours : bool
        Whether there are neighbour estimates.

    """
    before, after = shapes_of(1, n_vehicles), shapes_of(2, n_vehicles)
    names = [name for name in after if has_neighbours or name not in NEIGHBOURS]
    numbers = sum(_count(after[name]) - _count(before[name]) for name in names)
    return _NUMBER_BYTES * (numbers + 2 * n_vehicles * n_actuators)


def bytes_of_rows(*, sent: float, heard: float) -> float:
    """Return the size of this number of sent packets, and of this number of outcomes at receivers (bytes)."""
    event = 6 + 3
    return _NUMBER_BYTES * (sent * (3 + event) + heard * (4 + 1 + event))
