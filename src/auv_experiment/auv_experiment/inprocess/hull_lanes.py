"""
Many hulls of one model under one controller, laid out so that vector instructions move several at once.

Hulls fly in blocks of 16 lanes: a block has first the north coordinates of all its hulls, then the east
ones, and so on. The 16 rows of a block are a fixed distance apart, so the compiler knows that they do not
overlap. The lanes in use are padded to a multiple of eight with unused hulls.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_control.controllers.velocity_pi import Gains, control
from auv_core.compiled import entry, inlined, inner
from auv_core.geometry import Vec3, heading_from_quaternion, quaternion_from_heading
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.models.six_dof import Constants, derivative, limited_wrench, normalised
from auv_flocking.flock_rates import KNOWS_PATH, Instant, Paths

Floats = NDArray[np.float64]

LANES = 16
ROWS = 16  # 13 of a hull, 3 of the integral of its controller
VEHICLE_RATES = (
    "void(float64[:, ::1], float64[:, ::1], Paths, Instant, float64[::1], float64[:, ::1], float64[:, ::1], "
    "float64[:, :, ::1])"
)
_AT_ONCE = 8
_NOBODY = (0.0, 0.0, 0.0, 1.0, *(12 * (0.0,)))


class Hull(NamedTuple):
    """A model and its actuator limits, the gains of its controller, and the velocity of the water (NED)."""

    model: Constants
    limits: Vec6
    gains: Gains
    water_mps: Vec3

    @property
    def numbers(self) -> Floats:
        """The same as an array for `hull_rates`, so that a call does not copy 36 numbers."""
        return np.array([number for part in self for number in part])


@inlined
def _hull(c: Floats) -> Hull:
    """Return the hull with the `numbers` `c`."""
    model = Constants(
        c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10],
        c[11], c[12], c[13], c[14], c[15], c[16], c[17], c[18], c[19], c[20],
    )  # fmt: skip
    limits = (c[21], c[22], c[23], c[24], c[25], c[26])
    gains = Gains(c[27], c[28], c[29], c[30], c[31], c[32])
    return Hull(model, limits, gains, (c[33], c[34], c[35]))


def to_lanes(states: Sequence[State]) -> Floats:
    """Return hulls, 16 numbers each, as (B, 256) blocks."""
    blocks = -(-len(states) // LANES)
    table = np.tile(np.array(_NOBODY), (blocks * LANES, 1))
    table[: len(states)] = states
    return np.ascontiguousarray(table.reshape(blocks, LANES, ROWS).transpose(0, 2, 1)).reshape(blocks, -1)


def from_lanes(lanes: Floats, count: int) -> Floats:
    """Return (..., count, 16) numbers of hulls from (..., B, 256) blocks."""
    blocks = lanes.reshape(*lanes.shape[:-1], -1, LANES).swapaxes(-1, -2)
    return blocks.reshape(*lanes.shape[:-2], -1, blocks.shape[-1])[..., :count, :]


@inner
def lanes_in_use(count: int, block: int) -> int:
    """Return the number of used lanes of a block, a multiple of eight."""
    left = min(count - block * LANES, LANES)
    return (left + _AT_ONCE - 1) // _AT_ONCE * _AT_ONCE


@entry(VEHICLE_RATES, allocates=False)
def hull_rates(
    lanes: Floats,
    velocities: Floats,
    paths: Paths,
    now: Instant,
    hull_numbers: Floats,
    wanted: Floats,
    wrenches: Floats,
    rates: Floats,
) -> None:
    """
    Write the rates of hulls and of their controllers' integral states, and the commanded wrenches.

    Parameters
    ----------
    lanes : (B, 256) array
        Hulls in B blocks.
    velocities : (N, 3) array
        Commanded velocity over ground (m/s; NED).
    paths, now : Paths, Instant
        Only the attitude of the paths, and whose heading each vehicle takes.
    hull_numbers : (36,) array
        `Hull.numbers`; empty for points.
    wanted : (B, 80) array
        Work space for the inputs of the controllers.
    wrenches : (B, 96) array
        Output: wrenches commanded by the controllers (N, N m; body).
    rates : (4, B, 256) array
        Output: rates of the hulls, by stage.

    """
    count, rates_now, hull = len(velocities), rates[now.stage], _hull(hull_numbers)
    for i in range(count):
        block, lane, path = i // LANES, i % LANES, paths.path_of[i]
        for axis in range(3):
            wanted[block, lane + axis * LANES] = velocities[i, axis]
        guide = paths.guide_of[i]
        if guide == KNOWS_PATH:
            wanted[block, lane + 3 * LANES] = paths.table[now.row, path, 6]
            wanted[block, lane + 4 * LANES] = paths.table[now.row, path, 7]
        else:
            x = _plant(lanes, guide // LANES, guide % LANES)
            q = quaternion_from_heading(heading_from_quaternion((x[3], x[4], x[5], x[6])))
            wanted[block, lane + 3 * LANES], wanted[block, lane + 4 * LANES] = q[0], q[3]
    for block in range((count + LANES - 1) // LANES):
        for lane in range(lanes_in_use(count, block)):
            x = _plant(lanes, block, lane)
            attitude, nu = (x[3], x[4], x[5], x[6]), (x[7], x[8], x[9], x[10], x[11], x[12])
            integral = _three(lanes, block, lane + 13 * LANES)
            velocity = _three(wanted, block, lane)
            facing = (wanted[block, lane + 3 * LANES], 0.0, 0.0, wanted[block, lane + 4 * LANES])
            tau, growth = control(attitude, nu, integral, velocity, facing, hull.gains)
            given = limited_wrench(tau, hull.limits)
            _put_plant(rates_now, block, lane, derivative(x, given, hull.water_mps, hull.model))
            _put_three(rates_now, block, lane + 13 * LANES, growth)
            _put_three(wrenches, block, lane, (tau[0], tau[1], tau[2]))
            _put_three(wrenches, block, lane + 3 * LANES, (tau[3], tau[4], tau[5]))


@entry(VEHICLE_RATES, allocates=False)
def point_rates(
    motion: Floats,
    velocities: Floats,
    paths: Paths,
    now: Instant,
    hull_numbers: Floats,
    wanted: Floats,
    wrenches: Floats,
    rates: Floats,
) -> None:
    """Write the rates of points, (N, 3): the commanded velocities."""
    for i in range(len(velocities)):
        for axis in range(3):
            rates[now.stage, i, axis] = velocities[i, axis]


@inner
def normalise(count: int, lanes: Floats) -> None:
    """Normalise all attitude quaternions."""
    for block in range((count + LANES - 1) // LANES):
        for lane in range(lanes_in_use(count, block)):
            _put_plant(lanes, block, lane, normalised(_plant(lanes, block, lane)))


@inlined
def _three(rows: Floats, block: int, at: int) -> Vec3:
    """Return three numbers of a hull from index `at` on."""
    return (rows[block, at], rows[block, at + LANES], rows[block, at + 2 * LANES])


@inlined
def _put_three(rows: Floats, block: int, at: int, v: Vec3) -> None:
    """Write three numbers of a hull from index `at` on."""
    rows[block, at], rows[block, at + LANES], rows[block, at + 2 * LANES] = v[0], v[1], v[2]


@inlined
def _plant(lanes: Floats, block: int, at: int) -> State:
    """Return the 13 numbers of a hull."""
    x, y, z = _three(lanes, block, at)
    qw, qx, qy = _three(lanes, block, at + 3 * LANES)
    qz, u, v = _three(lanes, block, at + 6 * LANES)
    w, p, q = _three(lanes, block, at + 9 * LANES)
    return (x, y, z, qw, qx, qy, qz, u, v, w, p, q, lanes[block, at + 12 * LANES])


@inlined
def _put_plant(lanes: Floats, block: int, at: int, x: State) -> None:
    """Write the 13 numbers of a hull."""
    _put_three(lanes, block, at, (x[0], x[1], x[2]))
    _put_three(lanes, block, at + 3 * LANES, (x[3], x[4], x[5]))
    _put_three(lanes, block, at + 6 * LANES, (x[6], x[7], x[8]))
    _put_three(lanes, block, at + 9 * LANES, (x[9], x[10], x[11]))
    lanes[block, at + 12 * LANES] = x[12]
