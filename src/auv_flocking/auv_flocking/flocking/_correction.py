"""
The correction of `communication_aware` in numbers: cohesion, repulsion by age and uncertainty, the barrier.

Symbols, reasons and sources are in that module. This is its arithmetic, for one vehicle and its neighbours,
in a form that also compiles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inner
from auv_core.geometry import Vec3, limited
from auv_flocking.central import Numbers, along, no_strength
from auv_flocking.flocking._avoidance import barrier_margin_m, obstacle_bound, obstacle_spacing_m
from auv_flocking.flocking._half_spaces import into_half_spaces
from auv_flocking.flocking._layers import Layering, aside, crossing_margin_m, levelled
from auv_flocking.neighbours.estimates import (
    AGE,
    COVARIANCE,
    FLOCK_STAMP,
    NAVIGATION_SD,
    POSITION,
    SONAR_AGE,
    VELOCITY,
)

Matrix = NDArray[np.float64]
Known = tuple[Matrix, NDArray[np.int64], Matrix, Matrix]


class Gains(NamedTuple):
    """Parameters of the law, with the same names; `barrier` is 1 with a barrier and 0 without."""

    spacing_m: float
    cohesion_gain_ps: float
    gathering_m: float
    gathering_budget_rad: float
    lag_budget_rad: float
    correction_limit_mps: float
    reach_m: float
    spacing_sigmas: float
    widening_limit_m: float
    closing_ratio: float
    barrier: float
    barrier_distance_m: float
    barrier_rate_ps: float
    barrier_sigmas: float
    response_s: float
    navigation_sigmas: float


class Outlook(NamedTuple):
    """
    A neighbour estimate relative to the own vehicle.

    normal: direction from the neighbour; sigma_m: deviation sigma_j; spacing_m: d_j; gain: g_j; closing_mps:
    its velocity in the flock along the normal, positive if it comes nearer.
    """

    normal: Vec3
    distance_m: float
    age_s: float
    sigma_m: float
    spacing_m: float
    gain: float
    closing_mps: float


strength = obstacle_strength = no_strength

_NO_DIRECTION_M = 1e-9
_NO_AGE_S = 1e-3


@inner
def matched(lag_budget_rad: float, age_s: float) -> float:
    """Return the factor that reduces a gain to what information of this age allows."""
    return min(1.0, lag_budget_rad / max(age_s, _NO_AGE_S))


@entry("UniTuple(float64, 2)(float64[:, ::1], int64[::1], float64[::1], float64, float64)", allocates=False)
def remember_ages(
    rows: Matrix, addresses: NDArray[np.int64], usual_s: Matrix, running_s: float, share: float
) -> tuple[float, float]:
    """
    Update the average ages of packets by one period; return the sum of the effective ages, and the age of
    the oldest packet (s).

    Parameters
    ----------
    rows, addresses : (n, WIDTH), (n,) array
        The neighbours.
    usual_s : (256,) array
        Recent average age of the packets, by address (s); negative before the first. Updated.
    running_s : float
        Time since the last new neighbour (s).
    share : float
        Weight of the current age.

    """
    total_s = oldest_s = 0.0
    for k in range(len(rows)):
        address, age_s = addresses[k], float(rows[k, AGE])
        before_s = float(usual_s[address])
        if before_s < 0.0:
            before_s = running_s
        now_s = before_s + share * (age_s - before_s)
        usual_s[address] = now_s
        total_s += max(age_s, now_s)
        oldest_s = max(oldest_s, age_s)
    return total_s, oldest_s


@entry("int64(float64[:, ::1], float64)", allocates=False)
def newer_stamp(rows: Matrix, stamp_s: float) -> int:
    """Return the row with the newest flock velocity, if stamped later than `stamp_s` (s); -1: none."""
    newest, newest_s = -1, stamp_s
    for k in range(len(rows)):
        if rows[k, FLOCK_STAMP] > newest_s:
            newest, newest_s = k, float(rows[k, FLOCK_STAMP])
    return newest


@inner
def direction(own: Vec3, other: Vec3) -> tuple[Vec3, float]:
    """Return the unit vector from `other` to `own`, and the distance (m); up if there is no direction."""
    x, y, z = own[0] - other[0], own[1] - other[1], own[2] - other[2]
    distance_m = math.sqrt(x * x + y * y + z * z)
    if distance_m < _NO_DIRECTION_M:
        return (0.0, 0.0, -1.0), distance_m
    return (x / distance_m, y / distance_m, z / distance_m), distance_m


@inner
def _believed_m2(row: Matrix, normal: Vec3) -> float:
    """Return the variance of the distance to a neighbour by its filter (m^2)."""
    nx, ny, nz = normal
    xx, xy, xz = float(row[COVARIANCE]), float(row[COVARIANCE + 1]), float(row[COVARIANCE + 2])
    yy, yz, zz = float(row[COVARIANCE + 7]), float(row[COVARIANCE + 8]), float(row[COVARIANCE + 14])
    variance_m2 = (
        nx * nx * xx + ny * ny * yy + nz * nz * zz + 2.0 * (nx * ny * xy + nx * nz * xz + ny * nz * yz)
    )
    return max(variance_m2, 0.0)


@inner
def outlook(row: Matrix, usual_s: float, own: Vec3, flock: Vec3, gains: Gains) -> Outlook:
    """
    Return a neighbour estimate relative to the own vehicle.

    Parameters
    ----------
    row : (WIDTH,) array
        The estimate.
    usual_s : float
        Recent average age of its packets (s).
    own, flock : (3,) tuple
        Own position (m) and the flock's velocity (m/s; NED).
    gains : Gains
        The law's parameters.

    """
    other = (float(row[POSITION]), float(row[POSITION + 1]), float(row[POSITION + 2]))
    packet_s, sonar_s = float(row[AGE]), float(row[SONAR_AGE])
    age_s = min(packet_s, sonar_s)
    normal, distance_m = direction(own, other)
    vx, vy, vz = (
        float(row[VELOCITY]) - flock[0],
        float(row[VELOCITY + 1]) - flock[1],
        float(row[VELOCITY + 2]) - flock[2],
    )
    believed_m2 = _believed_m2(row, normal)
    moved_m = gains.closing_ratio * age_s * math.sqrt(vx * vx + vy * vy + vz * vz)
    sigma_m = math.sqrt(believed_m2 + moved_m * moved_m)
    lasting_m = min(math.sqrt(believed_m2), float(row[NAVIGATION_SD]))
    # Gains use average ages; a sonar contact counts as old as the hull's own lag.
    gain_age_s = max(sonar_s, gains.response_s) if sonar_s < packet_s else max(packet_s, usual_s)
    wider_m = gains.spacing_sigmas * sigma_m + gains.navigation_sigmas * lasting_m
    spacing_m = gains.spacing_m + min(wider_m, gains.widening_limit_m)
    gain = matched(gains.lag_budget_rad, gain_age_s)
    closing_mps = normal[0] * vx + normal[1] * vy + normal[2] * vz
    return Outlook(normal, distance_m, age_s, sigma_m, spacing_m, gain, closing_mps)


@inner
def neighbour_bound(view: Outlook, gains: Gains) -> float:
    """
    Return the smallest allowed velocity along the direction from a neighbour (m/s), in the flock's frame.

    It is half of what both may close, or what is left of the whole if the neighbour closes by more than half.
    """
    rate_ps = min(gains.barrier_rate_ps, 1.0 / max(view.age_s, _NO_AGE_S))
    margin_m = barrier_margin_m(view.sigma_m, gains)
    whole_mps = rate_ps * (view.distance_m - gains.barrier_distance_m - margin_m)
    least_mps = max(-0.5 * whole_mps, view.closing_mps - whole_mps)
    return min(least_mps, gains.correction_limit_mps)


@inner
def _cohesion_gain_ps(far_m: float, age_s: float, gains: Gains) -> float:
    """
    Return the gain towards a centre `far_m` away (1/s).

    It is matched to the age near the centre, and less so for the part of the way outside of `gathering_m`.
    """
    near = matched(gains.lag_budget_rad, age_s)
    outside = max(near, matched(gains.gathering_budget_rad, age_s))
    share = 1.0 - gains.gathering_m / far_m if far_m > gains.gathering_m else 0.0
    return gains.cohesion_gain_ps * (near + share * (outside - near))


@entry(
    "TUPLE3(TUPLE3, TUPLE3, TUPLE3, Tuple((float64[:, ::1], int64[::1], float64[::1], float64[:, ::1])), "
    "float64, Tuple((TUPLE16, TUPLE5)), UniTuple(float64[::1], 2), float64[:, ::1])"
)
def correction(
    own: Vec3,
    centre: Vec3,
    flock: Vec3,
    known: Known,
    age_s: float,
    numbers: tuple[tuple[float, ...], tuple[float, ...]],
    strength_numbers: tuple[Numbers, Numbers],
    pushes: Matrix,
) -> Vec3:
    """
    Return the velocity that a vehicle adds to the flock's (m/s; NED).

    `strength` and `obstacle_strength` belong to the separation law for which this function is specialised.

    Parameters
    ----------
    own, centre, flock : (3,) tuple
        Own position and estimate of the flock's centre (m), and the flock's velocity (m/s); NED.
    known : tuple of four arrays
        The neighbours, (n, WIDTH), and their addresses, (n,); the recent average age of their packets, by
        address, (256,) (s); the obstacles, (k, 8), see `_avoidance`.
    age_s : float
        Mean age A of the information (s).
    numbers : tuple of (16,) tuple and (5,) tuple
        The law's `Gains`, and the `Layering`: how the vehicle takes its layer of depth.
    strength_numbers : tuple of two arrays
        Parameters of the separation law for neighbours and for obstacles; see `auv_flocking.central`.
    pushes : (n + k, 3) or (0, 3) array
        Velocities from another kind of separation law, for neighbours and obstacles (m/s).

    """
    gains, layer = Gains(*numbers[0]), Layering(*numbers[1])
    rows, addresses, usual_s, obstacles = known
    n, count = len(rows), len(rows) + len(obstacles)
    x, y, z = centre[0] - own[0], centre[1] - own[1], centre[2] - own[2]
    gain_ps = _cohesion_gain_ps(math.sqrt(x * x + y * y + z * z), age_s, gains)
    is_layered, step_x, step_y = not math.isnan(layer.sinking_mps), 0.0, 0.0
    gain_ps *= layer.may_leave
    x, y, z = gain_ps * x, gain_ps * y, gain_ps * z
    limit_mps = min(gains.correction_limit_mps, gains.reach_m / max(age_s, _NO_AGE_S))
    half_spaces = np.empty((count, 4))
    for k in range(count):
        if k < n:
            view = outlook(rows[k], float(usual_s[addresses[k]]), own, flock, gains)
            normal, factor, spacing_m = view.normal, view.gain, view.spacing_m
            other = (float(rows[k, POSITION]), float(rows[k, POSITION + 1]), float(rows[k, POSITION + 2]))
            bound_mps = neighbour_bound(view, gains)
            if is_layered:
                margin_m = barrier_margin_m(view.sigma_m, gains)
                if layer.is_in == 0.0:
                    margin_m = crossing_margin_m(view.sigma_m, view.age_s)
                keep_m = gains.barrier_distance_m + margin_m
                dx, dy, _ = aside(own, other, int(addresses[k]), view.age_s, keep_m, layer)
                step_x, step_y = step_x + dx, step_y + dy
                if layer.is_in > 0.0:
                    normal, bound_mps = levelled(normal, bound_mps, layer.sinking_mps)
        else:
            row = obstacles[k - n]
            other, spacing_m = (float(row[0]), float(row[1]), float(row[2])), obstacle_spacing_m(row, gains)
            normal, distance_m = direction(own, other)
            factor = matched(gains.lag_budget_rad, gains.response_s)
            bound_mps = obstacle_bound(row, normal, distance_m, flock, gains)
        if len(pushes) > 0:
            dx, dy, dz = float(pushes[k, 0]), float(pushes[k, 1]), float(pushes[k, 2])
        elif k < n:
            dx, dy, dz = along(own, other, spacing_m, strength, strength_numbers[0])
        else:
            dx, dy, dz = along(own, other, spacing_m, obstacle_strength, strength_numbers[1])
        x, y, z = x + factor * dx, y + factor * dy, z + factor * dz
        half_spaces[k, 0], half_spaces[k, 1], half_spaces[k, 2] = normal
        half_spaces[k, 3] = bound_mps
    asked = limited((x, y, z), limit_mps)
    if is_layered:
        asked = (asked[0], asked[1], layer.sinking_mps)
        if step_x != 0.0 or step_y != 0.0:
            asked = (step_x, step_y, 0.0)
    if gains.barrier == 0.0 or count == 0:
        return asked
    return limited(into_half_spaces(asked, half_spaces), gains.correction_limit_mps)
