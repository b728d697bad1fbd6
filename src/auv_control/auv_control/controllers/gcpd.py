"""
Gravity-compensated PD into a safe region with layered repulsion, thesis chapter 4, Eqs. (4.3)-(4.14).

    tau_i = -J^T k_p (alpha dE/dp_i + beta sum_j dP_ij/dp_i) - K_v nu_i + g(eta_i)

E pulls the vehicle into a hollow cylinder, P_ij repels it from the others (`auv_control.region`), g
compensates weight minus buoyancy and the righting moment, K_v damps. No vehicle follows another, and there is
no path.

Deviation: J^T is the transposed rotation matrix of the attitude quaternion, and g is written with its third
row instead of sines and cosines of Euler angles, so that no pitch is singular. Deviation: the printed
velocity term is ambiguous; here it is -K_v nu. For equal gains and a level hull, the readings J^T K_v J nu
and J^T K_v eta_dot are the same. Deviation: `max_force_n` limits steering and damping, before g is added, so
that the weight is always compensated. Deviation: the gains of the layers are not in the thesis. 0.1, the only
printed candidate, lets most groups collide; with 100 and 500 there is no collision in 98 of 100 random
starts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from auv_control.controllers import MotionView, RegionLaw
from auv_control.region import (
    Layers,
    Ring,
    layer_gradient,
    layer_potential,
    region_gradient,
    region_potential,
)
from auv_core.geometry import Quat, Vec3, ned_to_body
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Region, layers and gains; defaults from thesis Section 4.6, but the layers' gains are ours."""

    centre_ned_m: Vec3 = param("centre of the ring (m; NED)", default=(10.0, 10.0, 10.0))
    inner_radius_m: float = param("radius r of the ring's hole (m)", default=0.3, minimum=0.0)
    outer_radius_m: float = param("outer radius R of the ring (m)", default=2.5, above=0.0)
    height_m: float = param("height h of the ring (m)", default=1.0, above=0.0)
    region_gain_pm3: float = param("gain k_l of the region functions (1/m^3)", default=0.1, above=0.0)
    layer_radii_m: tuple[float, ...] = param(
        "radii r_1 > r_2 > ... of the layers around a neighbour (m)", default=(1.0, 0.5), above=0.0
    )
    layer_gains_pm3: tuple[float, ...] = param(
        "gains k_1 <= k_2 <= ... of the layers (1/m^3)", default=(100.0, 500.0), minimum=0.0
    )
    region_weight: float = param("weight alpha of the region", default=1.0, above=0.0)
    layer_weight: float = param("weight beta of the layers", default=2.0, minimum=0.0)
    force_gain_n: float = param("gain k_p from potential gradient to force (N)", default=55.0, above=0.0)
    damping_gain: Vec6 = param(
        "diagonal of K_v (N s/m, N m s/rad; body)", default=(30.0, 30.0, 30.0, 30.0, 30.0, 30.0), minimum=0.0
    )
    gravity_compensation: bool = param("whether g(eta) is added", default=True)
    weight_n: float = param("weight in g (N)", default=1226.25, minimum=0.0)
    buoyancy_n: float = param("buoyancy in g (N)", default=1109.4848615418, minimum=0.0)
    cog_z_m: float = param("centre of gravity below the hull's centre (m; body z)", default=0.05, minimum=0.0)
    max_force_n: float | None = param(
        "limit of the magnitude of the steering and damping force (N), not in the thesis; null: none",
        default=None,
        above=0.0,
    )

    def __post_init__(self) -> None:
        if self.inner_radius_m >= self.outer_radius_m:
            raise ValueError(
                f"inner_radius_m: {self.inner_radius_m!r} is not allowed; "
                f"allowed: less than outer_radius_m = {self.outer_radius_m!r}"
            )
        if len(self.layer_radii_m) != len(self.layer_gains_pm3):
            raise ValueError(
                f"layer_gains_pm3: {len(self.layer_gains_pm3)} gains are not allowed; "
                f"allowed: one for each of the {len(self.layer_radii_m)} radii"
            )
        if any(b >= a for a, b in zip(self.layer_radii_m, self.layer_radii_m[1:], strict=False)):
            raise ValueError(
                f"layer_radii_m: {list(self.layer_radii_m)!r} is not allowed; "
                "allowed: each smaller than the one before"
            )
        if any(b < a for a, b in zip(self.layer_gains_pm3, self.layer_gains_pm3[1:], strict=False)):
            raise ValueError(
                f"layer_gains_pm3: {list(self.layer_gains_pm3)!r} is not allowed; "
                "allowed: none smaller than the one before, since inner layers repel more strongly"
            )

    @property
    def ring(self) -> Ring:
        """The region to steer to."""
        return Ring(self.inner_radius_m, self.outer_radius_m, self.height_m, self.centre_ned_m)

    @property
    def layers(self) -> Layers:
        """Radius (m) and gain (1/m^3) of each layer, from the outermost."""
        return tuple(zip(self.layer_radii_m, self.layer_gains_pm3, strict=True))


class Controller(RegionLaw):
    """The law; it has no state."""

    command = "wrench"
    follows = "region"
    candidates = ("energy",)
    shared_candidate = True
    proof_gap = (
        "the thesis has no proof here; the total energy decreases by nu^T (D + K_v) nu in still water with "
        "exact gravity compensation, equal gains, no force limit and the neighbours' true positions; "
        "without one of these it may increase"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params
        self._ring = params.ring
        self.region = params.ring.box
        self._layers = params.layers
        self._region_force_n = params.force_gain_n * params.region_weight
        self._layer_force_n = params.force_gain_n * params.layer_weight
        is_carried = params.gravity_compensation
        self._heavy_n = params.weight_n - params.buoyancy_n if is_carried else 0.0
        self._righting_nm = params.cog_z_m * params.weight_n if is_carried else 0.0
        self._limit_n = math.inf if params.max_force_n is None else params.max_force_n

    def initial_state(self, view: MotionView) -> State:
        """Return (): the law has no state."""
        return ()

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench of thesis Eq. (4.13) (N, N m; body) and ()."""
        nav = view.nav
        x, y, z = ned_to_body(nav.attitude, self._slope(nav.position, view.neighbours))
        (gx, gy, gz), (gk, gm) = self._restoring(nav.attitude)
        k = self._params.damping_gain
        u, v, w, p, q, r = nav.nu
        fx, fy, fz = -x - k[0] * u, -y - k[1] * v, -z - k[2] * w
        length_n = math.sqrt(fx * fx + fy * fy + fz * fz)
        if length_n > self._limit_n:
            scale = self._limit_n / length_n
            fx, fy, fz = scale * fx, scale * fy, scale * fz
        return (gx + fx, gy + fy, gz + fz, gk - k[3] * p, gm - k[4] * q, -k[5] * r), ()

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """
        Return the vehicle's share of the energy (J): nu^T M nu / 2 + k_p (alpha E_i + beta/2 sum_j P_ij).

        The potential of a pair is shared equally by its two vehicles.
        """
        own = view.nav.position
        region_m = region_potential(own, self._ring, self._params.region_gain_pm3)
        layers_m = sum([layer_potential(own, other, self._layers) for other in view.neighbours])
        potential_j = self._region_force_n * region_m + 0.5 * self._layer_force_n * layers_m
        return (kinetic_energy(view.nav.nu) + potential_j,)

    def _slope(self, own: Vec3, neighbours: tuple[Vec3, ...]) -> Vec3:
        """Return k_p times the thesis's Delta-epsilon_i, Eq. (4.12) (N; NED)."""
        x, y, z = region_gradient(own, self._ring, self._params.region_gain_pm3)
        a, b = self._region_force_n, self._layer_force_n
        x, y, z = a * x, a * y, a * z
        for other in neighbours:
            dx, dy, dz = layer_gradient(own, other, self._layers)
            x, y, z = x + b * dx, y + b * dy, z + b * dz
        return x, y, z

    def _restoring(self, attitude: Quat) -> tuple[Vec3, tuple[float, float]]:
        """Return g(eta) without its last component, which is 0, thesis Eq. (4.14) (N, N m; body)."""
        down = ned_to_body(attitude, (0.0, 0.0, 1.0))
        heavy_n, righting_nm = self._heavy_n, self._righting_nm
        force_n = (-heavy_n * down[0], -heavy_n * down[1], -heavy_n * down[2])
        return force_n, (righting_nm * down[1], -righting_nm * down[0])
