"""
Sliding-mode path following with a boundary layer, proposed as future work in thesis Section 7.3.

Errors are reference minus actual (`auv_control.tracking_errors`), in surge, sway and yaw.  The law uses

    nu_v = nu_r + sigma(eta_e) + g F_rep,      sigma(e) = lambda e / sqrt(1 + |lambda e|^2 / v^2)

a velocity that leads the vehicle to its path, at most with the approach speed v, and around obstacles, whose
potential is that of the other laws. The sliding variable is s = nu_v - nu, and

    tau = M^ nu_v' + C^(nu) nu + D^(nu) nu_v + k sat(s / phi)

with the law's model of the vehicle (hats). With V = s^T M s / 2 and the model error delta,

    V' = -s^T D(nu) s - s^T k sat(s / phi) + s^T delta

so that V decreases wherever |s_i| > phi_i, if k_i > |delta_i|. For any disturbance below k, the vehicle
enters the layer |s_i| <= phi_i and stays in it, and |eta_e| becomes at most about phi / lambda. The layer
avoids the chattering of k sign(s): in it the law is proportional with gain k / phi.

Yaw is not controlled, as in the thesis's laws, unless its component of k is above zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from auv_control.controllers import MotionLaw, MotionView
from auv_control.tracking_errors import TrackingErrors, ned_force_in_frame, tracking_errors
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param

Vec2 = tuple[float, float]
_NO_DIRECTION_M2 = 1e-18


@dataclass(frozen=True)
class Params:
    """Gains in the order surge, sway, yaw; by default the vehicle model is that of thesis Table 2.1."""

    frame: str = param("axes of errors and forces", default="body", choices=("body", "flat"))
    error_rate_ps: float = param(
        "rate lambda at which an error decays on s = 0 (1/s)", default=0.5, above=0.0
    )
    approach_speed_mps: float = param("limit v of the speed towards the path (m/s)", default=0.6, above=0.0)
    switching_gain: Vec3 = param(
        "k, the largest disturbance that is rejected (N, N, N m); yaw 0: not controlled",
        default=(60.0, 80.0, 0.0),
        minimum=0.0,
    )
    boundary_layer: Vec3 = param(
        "half width phi of the layer (m/s, m/s, rad/s)", default=(0.1, 0.1, 0.1), above=0.0
    )
    inertia: Vec3 = param("M: masses (kg) and inertia (kg m^2)", default=(215.0, 265.0, 80.0), above=0.0)
    linear_damping: Vec3 = param("d_L (N s/m, N s/m, N m s/rad)", default=(70.0, 100.0, 50.0), minimum=0.0)
    quadratic_damping: Vec3 = param(
        "d_Q (N s^2/m^2, N s^2/m^2, N m s^2/rad^2)", default=(100.0, 200.0, 100.0), minimum=0.0
    )
    obstacle_gain_m2ps: float = param(
        "factor g on the gradient of the obstacles' potential (m^2/s)", default=0.005, minimum=0.0
    )
    truncate_repulsion: bool = param(
        "whether to ignore obstacles beyond their safety distance, where they would attract", default=True
    )

    def __post_init__(self) -> None:
        for axis, gain in enumerate(self.switching_gain[:2]):
            if gain <= 0.0:
                raise ValueError(
                    f"switching_gain[{axis}]: {gain!r} is not allowed; allowed: a finite number above 0"
                )


class Controller(MotionLaw):
    """The law; it has no state."""

    command = "wrench"
    follows = "path"
    candidates = ("sliding",)
    shared_candidate = False
    proof_gap = (
        "not a law of the thesis; V always decreases with the vehicle's true parameters in still water and "
        "continuous time, otherwise only outside the boundary layer and while k exceeds the disturbance by "
        "wrong parameters, current, noise, sampling and actuator limits"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params
        self._steers = params.switching_gain[2] > 0.0

    def initial_state(self, view: MotionView) -> State:
        """Return (): nothing is remembered."""
        return ()

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; in the frame's axes) and the rate of the empty state."""
        p = self._params
        errors = tracking_errors(view, p.frame)
        nu_v, rate = self._wanted(errors, view)
        u, v, r = view.nav.nu[0], view.nav.nu[1], view.nav.nu[5]
        m11, m22, m33 = p.inertia
        x = m11 * rate[0] - m22 * v * r + self._sliding_force(0, nu_v[0], u)
        y = m22 * rate[1] + m11 * u * r + self._sliding_force(1, nu_v[1], v)
        if not self._steers:
            return (x, y, 0.0, 0.0, 0.0, 0.0), ()
        n = m33 * rate[2] + (m22 - m11) * u * v + self._sliding_force(2, nu_v[2], r)
        return (x, y, 0.0, 0.0, 0.0, n), ()

    def sliding_variable(self, view: MotionView) -> Vec3:
        """Return s (m/s, m/s, rad/s; in the frame's axes), with 0 for a yaw that is not controlled."""
        nu_v, _ = self._wanted(tracking_errors(view, self._params.frame), view)
        nu = view.nav.nu
        return nu_v[0] - nu[0], nu_v[1] - nu[1], nu_v[2] - nu[5] if self._steers else 0.0

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """Return s^T M s / 2 (J)."""
        x, y, n = self.sliding_variable(view)
        return (kinetic_energy((x, y, 0.0, 0.0, 0.0, n)),)

    def _sliding_force(self, axis: int, wanted: float, actual: float) -> float:
        """Return D^(nu) nu_v + k sat(s / phi) of one axis (N, N m)."""
        p = self._params
        layer = (wanted - actual) / p.boundary_layer[axis]
        damping = p.linear_damping[axis] + p.quadratic_damping[axis] * abs(actual)
        return damping * wanted + p.switching_gain[axis] * max(-1.0, min(1.0, layer))

    def _wanted(self, errors: TrackingErrors, view: MotionView) -> tuple[Vec3, Vec3]:
        """Return nu_v (m/s, m/s, rad/s) and its rate, both in the frame's axes."""
        p = self._params
        turning = view.nav.nu[5] if p.frame == "body" else 0.0
        (sx, sy), (tx, ty) = self._approach(errors)
        (ox, oy), (qx, qy) = self._avoidance(view)
        sx, sy = sx + ox, sy + oy
        ur, vr, rr = errors.reference
        ax, ay, ar = errors.reference_rate
        rate_ps = p.error_rate_ps
        return (
            (ur + sx, vr + sy, rr + rate_ps * errors.pose[2]),
            (
                ax + tx + qx + turning * sy,
                ay + ty + qy - turning * sx,
                ar + rate_ps * errors.velocity[2],
            ),
        )

    def _approach(self, errors: TrackingErrors) -> tuple[Vec2, Vec2]:
        """Return sigma(eta_e) (m/s) and J^T times the rate of its NED vector (m/s^2)."""
        p = self._params
        x, y = p.error_rate_ps * errors.pose[0], p.error_rate_ps * errors.pose[1]
        fast, sideways = p.error_rate_ps * errors.velocity[0], p.error_rate_ps * errors.velocity[1]
        bound = p.approach_speed_mps * p.approach_speed_mps
        scale = 1.0 / math.sqrt(1.0 + (x * x + y * y) / bound)
        fading = scale * scale * scale * (x * fast + y * sideways) / bound
        return (scale * x, scale * y), (scale * fast - fading * x, scale * sideways - fading * y)

    def _avoidance(self, view: MotionView) -> tuple[Vec2, Vec2]:
        """
        Return g F_rep (m/s) and J^T times the rate of its NED vector (m/s^2), in the frame's axes.

        F_rep is that of `auv_control.avoidance`: with q = |p - p_o|^2, (p - p_o) 2 (d^2 - q) / q^2.
        """
        if not view.obstacles:
            return (0.0, 0.0), (0.0, 0.0)
        p = self._params
        north, east = self._ned_velocity(view)
        x = y = xd = yd = 0.0
        for centre, safety_m in view.obstacles:
            dx, dy = view.nav.position[0] - centre[0], view.nav.position[1] - centre[1]
            square, limit = dx * dx + dy * dy, safety_m * safety_m
            if square < _NO_DIRECTION_M2 or (p.truncate_repulsion and square >= limit):
                continue
            factor = 2.0 * p.obstacle_gain_m2ps * (limit - square) / (square * square)
            closing = 2.0 * (dx * north + dy * east)
            change = (
                2.0 * p.obstacle_gain_m2ps * (square - 2.0 * limit) / (square * square * square) * closing
            )
            x, y = x + factor * dx, y + factor * dy
            xd, yd = xd + change * dx + factor * north, yd + change * dy + factor * east
        return ned_force_in_frame(view, (x, y), p.frame), ned_force_in_frame(view, (xd, yd), p.frame)

    def _ned_velocity(self, view: MotionView) -> Vec2:
        u, v = view.nav.nu[0], view.nav.nu[1]
        if self._params.frame == "flat":
            return u, v
        w, _, _, z = view.nav.attitude
        cosine, sine = w * w - z * z, 2.0 * w * z
        return cosine * u - sine * v, sine * u + cosine * v
