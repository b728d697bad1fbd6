"""
The stiffness of a separation law, so that laws are compared at equal stiffness.

A pair at the distance r moves apart with v(r) = r strength(r^2). Stiffness is -dv/dr (1/s), the rate at which
the law alone removes a small error of the distance. A flock of n vehicles at equal distances r is at rest
where n strength(r^2) balances its attraction

    K = k_c (1 - 1 / (n + 1)) + k_d

with k_d only where vehicles are attracted to the path. The 1 / (n + 1) is the bias of the thesis's consensus.
A stiffer law rests nearer to the spacing d, whatever its form: laws with other stiffness show their gains.
"""

from __future__ import annotations

from typing import Any

from scipy.optimize import brentq

from auv_flocking.flocking.potential import Params as FlockingParams
from auv_flocking.separation import CentralLaw, mathematical

_STEP_M = 1e-6
_NEAREST_RATIO = 0.1
"""Equilibria are looked for from this share of the spacing on."""
_GAINS: tuple[float, float] = (1e-3, 1e4)


def pair_speed_mps(law: CentralLaw, distance_m: float, spacing_m: float) -> float:
    """Return the velocity with which one vehicle of a pair moves away from the other (m/s; unit gain)."""
    return distance_m * law.strength(distance_m * distance_m, spacing_m, law.numbers)


def stiffness_ps(law: CentralLaw, distance_m: float, spacing_m: float) -> float:
    """Return -dv/dr at a distance (1/s), from the law's own function by central differences."""
    ahead = pair_speed_mps(law, distance_m + _STEP_M, spacing_m)
    behind = pair_speed_mps(law, distance_m - _STEP_M, spacing_m)
    return (behind - ahead) / (2.0 * _STEP_M)


def attraction_ps(params: FlockingParams, n_vehicles: int, *, followers_know_path: bool) -> float:
    """Return K (1/s), the attraction of a flock at equal distances."""
    path_ps = params.path_gain_ps if followers_know_path else 0.0
    return params.cohesion_gain_ps * (1.0 - 1.0 / (n_vehicles + 1)) + path_ps


def equilibrium_m(law: CentralLaw, attraction_ps: float, n_vehicles: int, spacing_m: float) -> float:
    """Return the distance of a flock of up to four vehicles at rest (m)."""

    def surplus_ps(distance_m: float) -> float:
        repulsion_ps = law.strength(distance_m * distance_m, spacing_m, law.numbers)
        return n_vehicles * repulsion_ps - attraction_ps

    return float(brentq(surplus_ps, _NEAREST_RATIO * spacing_m, spacing_m))


def resting_stiffness_ps(law: CentralLaw, attraction_ps: float, n_vehicles: int, spacing_m: float) -> float:
    """Return the stiffness at the distance at which the flock rests (1/s)."""
    return stiffness_ps(law, equilibrium_m(law, attraction_ps, n_vehicles, spacing_m), spacing_m)


def gain_for_stiffness(wanted_ps: float, attraction_ps: float, n_vehicles: int, spacing_m: float) -> float:
    """Return the gain with which the mathematical law has this stiffness where its own flock rests."""

    def surplus_ps(gain: float) -> float:
        law = mathematical_law(gain)
        return resting_stiffness_ps(law, attraction_ps, n_vehicles, spacing_m) - wanted_ps

    return float(brentq(surplus_ps, *_GAINS))


def gain_for_distance(wanted_m: float, attraction_ps: float, n_vehicles: int, spacing_m: float) -> float:
    """Return the gain with which a flock with the mathematical law rests at this distance."""
    unit_ps = mathematical_law(1.0).strength(wanted_m * wanted_m, spacing_m, mathematical_law(1.0).numbers)
    return attraction_ps / (n_vehicles * unit_ps)


def mathematical_law(gain: float) -> Any:
    """Return the mathematical law with this gain."""
    return mathematical.Separation(mathematical.Params(gain=gain))
