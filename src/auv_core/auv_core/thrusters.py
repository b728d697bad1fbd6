"""
Thrusters of a hull: where they are, what they can give, and how a demand becomes a force.

With the thrusters' forces f, n numbers (N, each along its thruster's direction d_i at the place r_i), the
wrench on the body is tau = T f with the columns [d_i; r_i x d_i] of the configuration matrix T (Fossen 2021,
Handbook of Marine Craft Hydrodynamics and Motion Control, chapter 11). Thrusters are numbered from 1.

The setting c of a thruster is in [-1, 1], and its force for a steady setting is

    f = f_max sgn(c) (max(0, |c| - c_d) / (1 - c_d))^2

with the dead zone c_d. The driver of the thruster takes a demand in N and inverts this map with the dead zone
that it assumes, so the dead zone shows only if the driver assumes another one.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inlined
from auv_core.geometry import Vec3
from auv_core.params import param

Floats = NDArray[np.float64]

_AXES = 6
_UNIT_TOLERANCE = 1e-3
_RANK_TOLERANCE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Thrusters:
    """Places, directions and limits of the thrusters of a hull; the empty lists are a hull without any."""

    positions_m: tuple[float, ...] = param(
        "places of the thrusters, three numbers each (m; body)", default=()
    )
    directions: tuple[float, ...] = param(
        "unit vectors along their positive forces, three numbers each (body)", default=()
    )
    max_forward_n: tuple[float, ...] = param(
        "largest positive force, one number for all or one for each (N)", default=(), above=0.0
    )
    max_backward_n: tuple[float, ...] = param(
        "largest negative force as a positive number, one for all or one for each (N)", default=(), above=0.0
    )
    lag_s: float = param("time constant with which a force follows its demand (s)", default=0.2, above=0.0)
    dead_zone: float = param(
        "part of the range of the setting, [-1, 1], that gives no force",
        default=0.0,
        minimum=0.0,
        maximum=0.9,
    )
    assumed_dead_zone: float | None = param(
        "dead zone that the drivers compensate; null: the true one, 0: none",
        default=None,
        minimum=0.0,
        maximum=0.9,
    )
    assumed_lag_s: float | None = param(
        "time constant that the vehicle's computer compensates (s); null: the true one, 0: none",
        default=None,
        minimum=0.0,
    )
    moment_arm_m: float = param(
        "length by which an error of a moment is divided where it is weighed against errors of forces (m)",
        default=0.4,
        above=0.0,
    )

    def __post_init__(self) -> None:
        if len(self.positions_m) % 3:
            raise ValueError(
                f"positions_m: {len(self.positions_m)} numbers are not allowed; "
                "allowed: three for each thruster"
            )
        if len(self.directions) != len(self.positions_m):
            raise ValueError(
                f"directions: {len(self.directions)} numbers are not allowed; allowed: "
                f"{len(self.positions_m)}, three for each of the {self.count} thrusters"
            )
        for index in range(self.count):
            length = math.hypot(*_three(self.directions, index))
            if abs(length - 1.0) > _UNIT_TOLERANCE:
                raise ValueError(
                    f"directions: a vector of length {length:.4g} (thruster {index + 1}) is not allowed; "
                    "allowed: length 1"
                )
        for name in ("max_forward_n", "max_backward_n"):
            size = len(getattr(self, name))
            if size != min(1, self.count) and size != self.count:
                raise ValueError(
                    f"{name}: {size} numbers are not allowed; allowed: one, or one for each of the "
                    f"{self.count} thrusters"
                )

    @property
    def count(self) -> int:
        """Number n of thrusters."""
        return len(self.positions_m) // 3

    @property
    def highest_n(self) -> Floats:
        """Largest forces (n,) (N)."""
        return np.array(_one_each(self.max_forward_n, self.count))

    @property
    def lowest_n(self) -> Floats:
        """Smallest forces (n,), which are negative (N)."""
        return -np.array(_one_each(self.max_backward_n, self.count))

    def matrix(self, lost: tuple[int, ...] = ()) -> Floats:
        """
        Return the configuration matrix T, (6, n): from forces (N) to the wrench (N, N m; body).

        Parameters
        ----------
        lost : tuple of int
            Numbers of the thrusters, from 1, that give no force: their columns are zero.

        """
        T = np.zeros((_AXES, self.count))
        for index in range(self.count):
            if index + 1 not in lost:
                T[:, index] = _column(_three(self.positions_m, index), _three(self.directions, index))
        return T


@dataclass(frozen=True, kw_only=True)
class ThrusterFault:
    """One thruster gives no force from a time on, and its vehicle knows that some time later."""

    thruster: int = param("number of the thruster, from 1; 0: none fails", default=0, minimum=0, maximum=64)
    t_s: float = param("time from which it gives no force (s)", default=0.0, minimum=0.0)
    known_after_s: float = param(
        "time after which the vehicle's computer knows it and allocates without that thruster (s)",
        default=5.0,
        minimum=0.0,
    )

    def has_begun(self, t_s: float) -> bool:
        """Return whether the thruster has failed at a time (s)."""
        return self.thruster > 0 and t_s >= self.t_s

    def is_known(self, t_s: float) -> bool:
        """Return whether the vehicle's computer knows at a time (s) that it has failed."""
        return self.has_begun(t_s - self.known_after_s)


def _three(numbers: tuple[float, ...], index: int) -> Vec3:
    return (numbers[3 * index], numbers[3 * index + 1], numbers[3 * index + 2])


def _one_each(numbers: tuple[float, ...], count: int) -> tuple[float, ...]:
    return numbers if len(numbers) == count else numbers * count


def _column(r: Vec3, d: Vec3) -> tuple[float, ...]:
    """Return [d; r x d] of a thruster at `r` (m) along `d`, whose length becomes 1."""
    length = math.hypot(*d)
    x, y, z = (component / length for component in d)
    return (x, y, z, r[1] * z - r[2] * y, r[2] * x - r[0] * z, r[0] * y - r[1] * x)


@inlined
def delivered_n(
    demand_n: float, lowest_n: float, highest_n: float, dead_zone: float, assumed: float
) -> float:
    """
    Return the steady force of a thruster for a demand (N).

    Parameters
    ----------
    demand_n : float
        Force asked of the driver (N).
    lowest_n, highest_n : float
        Limits of the force (N); the lowest is negative.
    dead_zone, assumed : float
        Dead zone of the thruster, and the one that its driver compensates (parts of the setting's range).

    """
    force_n = min(max(demand_n, lowest_n), highest_n)
    if force_n == 0.0 or dead_zone == assumed:
        return force_n
    most_n = highest_n if force_n > 0.0 else lowest_n
    setting = assumed + (1.0 - assumed) * math.sqrt(force_n / most_n)
    share = max(0.0, setting - dead_zone) / (1.0 - dead_zone)
    return most_n * share * share


def axis_maxima(T: Floats, lowest_n: Floats, highest_n: Floats) -> Floats:
    """
    Return the largest pure forces and moments, (6, 2): in the positive and the negative sense of each axis.

    All wrenches that thrusters can give are a zonotope, the image of a box. Each of its facets is spanned by
    as many columns of T as the rank of T less one, so its normals are few. Along an axis that T does not span
    the answer is 0.

    Parameters
    ----------
    T : (6, n) array
        Configuration matrix.
    lowest_n, highest_n : (n,) array
        Limits of the forces (N), of which the lowest are not positive and the highest not negative.

    """
    basis, sizes, _ = np.linalg.svd(T)
    rank = int((sizes > _RANK_TOLERANCE * max(sizes[:1], default=0.0)).sum())
    span = basis[:, :rank]
    maxima = np.zeros((_AXES, 2))
    if rank == 0:
        return maxima
    columns = span.T @ T
    groups = np.array(list(itertools.combinations(range(T.shape[1]), rank - 1)), dtype=int)
    _, _, rows = np.linalg.svd(columns.T[groups])
    normals = np.concatenate([rows[:, -1], -rows[:, -1]])
    along = normals @ columns
    supports = np.maximum(along * highest_n, along * lowest_n).sum(axis=1)
    for axis in range(_AXES):
        if abs(np.linalg.norm(span[axis]) - 1.0) > _RANK_TOLERANCE:
            continue
        for sense, sign in enumerate((1.0, -1.0)):
            lean = normals @ (sign * span[axis])
            facing = lean > _RANK_TOLERANCE
            maxima[axis, sense] = (supports[facing] / lean[facing]).min()
    return maxima
