"""
H-infinity path following: state feedback with integral action, for the future work of thesis Section 7.3.

Errors are reference minus actual (`auv_control.tracking_errors`), x = [q, e, nu_e] along surge and along
sway, where q is the integral of e, kept in NED.  The law is

    tau = M nu_r' + C(nu) nu_r + D(nu_r) nu_r + F x + F_rep

It has two parts: a feed-forward, the wrench that the model needs on the path, and the feedback F. For the
model linearised about the path, F keeps the worst gain from a disturbing force to errors and effort below
gamma. F, the solution P of its Riccati equation, gamma and the achieved norm come from
`./scripts/synthesise_h_infinity`; the numbers here and in the preset ``h_infinity_table_2_1`` are for thesis
Table 2.1. Nothing is solved at run time.

A linear law is valid for small errors. Larger ones are limited to `error_limit_m`, which bounds speed and
force of the approach. q is integrated only within `integral_zone_m` of the path and while no obstacle acts.
Yaw is not controlled, as in the thesis's laws.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from auv_control.avoidance import obstacle_force
from auv_control.controllers import MotionLaw, MotionView
from auv_control.riccati import check_feedback, check_norms, quadratic
from auv_control.tracking_errors import TrackingErrors, ned_force_in_frame, tracking_errors
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param

Vec2 = tuple[float, float]


@dataclass(frozen=True)
class Params:
    """Feedback with the certificate of its norm, and the model of thesis Table 2.1 in surge and sway."""

    frame: str = param("axes of errors and forces", default="body", choices=("body", "flat"))
    surge_gain: Vec3 = param(
        "F of surge: on q, e and nu_e (N/(m s), N/m, N s/m)",
        default=(25.0, 309.42697, 414.90099),
        minimum=0.0,
    )
    sway_gain: Vec3 = param(
        "F of sway: on q, e and nu_e (N/(m s), N/m, N s/m)", default=(25.0, 319.76424, 406.0945), minimum=0.0
    )
    surge_riccati: Vec6 = param(
        "upper triangle of P of surge, by rows (per m s, m, m/s)",
        default=(3.0942697, 6.6490099, 5.9722222, 76.323097, 73.918665, 99.115236),
    )
    sway_riccati: Vec6 = param(
        "upper triangle of P of sway, by rows (per m s, m, m/s)",
        default=(3.1976424, 7.9498339, 7.3611111, 94.321793, 94.152804, 119.57227),
    )
    gamma: Vec2 = param(
        "gain gamma of the Riccati equations, surge and sway",
        default=(0.83333333, 0.83333333),
        above=0.0,
    )
    achieved_norm: Vec2 = param(
        "H-infinity norm of the closed loops, surge and sway", default=(0.78396472, 0.78384623), above=0.0
    )
    error_limit_m: float = param("limit of position errors (m)", default=0.6, above=0.0)
    integral_zone_m: float = param(
        "distance to the path within which q is integrated (m)", default=0.5, minimum=0.0
    )
    inertia: Vec2 = param("masses m11 and m22 with added mass (kg)", default=(215.0, 265.0), above=0.0)
    linear_damping: Vec2 = param("linear damping d_L (N s/m)", default=(70.0, 100.0), minimum=0.0)
    quadratic_damping: Vec2 = param("quadratic damping d_Q (N s^2/m^2)", default=(100.0, 200.0), minimum=0.0)
    obstacle_gain_nm: float = param("factor on the obstacle potential (N m)", default=1.0, minimum=0.0)
    truncate_repulsion: bool = param(
        "whether to set the obstacle force to zero beyond the safety distance, where it attracts",
        default=True,
    )

    def __post_init__(self) -> None:
        hulls = tuple(zip(self.inertia, self.linear_damping, strict=True))
        check_feedback("surge", self.surge_gain, self.surge_riccati, hulls[0])
        check_feedback("sway", self.sway_gain, self.sway_riccati, hulls[1])
        check_norms(self.achieved_norm, self.gamma)


class Controller(MotionLaw):
    """The law; its state is q, north and east (m s)."""

    command = "wrench"
    follows = "path"
    candidates = ("quadratic",)
    shared_candidate = False
    proof_gap = (
        "not a law of the thesis; x^T P x decreases for the linearised model on a path without obstacles, "
        "but not always with limited errors during the approach, nonlinear drag, a turning hull, wrong "
        "parameters, current, noise or actuator limits"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params

    def initial_state(self, view: MotionView) -> State:
        """Return q = 0."""
        return (0.0, 0.0)

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; in the frame's axes) and the rate of q (m; NED)."""
        p = self._params
        errors = tracking_errors(view, p.frame)
        qx, qy = ned_force_in_frame(view, (state[0], state[1]), p.frame)
        ex, ey = errors.pose[0], errors.pose[1]
        distance_m = math.hypot(ex, ey)
        if distance_m > p.error_limit_m:
            ex, ey = ex * p.error_limit_m / distance_m, ey * p.error_limit_m / distance_m
        push = (0.0, 0.0)
        if view.obstacles:
            push = obstacle_force(
                view.nav.position, view.obstacles, p.obstacle_gain_nm, truncate=p.truncate_repulsion
            )
        fx, fy = ned_force_in_frame(view, push, p.frame)
        ax, ay = self._feed_forward(errors, view.nav.nu[5])
        a, b = p.surge_gain, p.sway_gain
        x = ax + fx + a[0] * qx + a[1] * ex + a[2] * errors.velocity[0]
        y = ay + fy + b[0] * qy + b[1] * ey + b[2] * errors.velocity[1]
        return (x, y, 0.0, 0.0, 0.0, 0.0), self._integral_rate(view, distance_m, push)

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """Return the sum of x^T P x over surge and sway (1, as the synthesis weighs x)."""
        p = self._params
        errors = tracking_errors(view, p.frame)
        q = ned_force_in_frame(view, (state[0], state[1]), p.frame)
        return (
            sum(
                quadratic(riccati, (q[axis], errors.pose[axis], errors.velocity[axis]))
                for axis, riccati in enumerate((p.surge_riccati, p.sway_riccati))
            ),
        )

    def _feed_forward(self, errors: TrackingErrors, r: float) -> Vec2:
        """Return M nu_r' + C(nu) nu_r + D(nu_r) nu_r along surge and sway (N)."""
        p = self._params
        m11, m22 = p.inertia
        u, v, _ = errors.reference
        surge = p.linear_damping[0] + p.quadratic_damping[0] * abs(u)
        sway = p.linear_damping[1] + p.quadratic_damping[1] * abs(v)
        return (
            m11 * errors.reference_rate[0] - m22 * r * v + surge * u,
            m22 * errors.reference_rate[1] + m11 * r * u + sway * v,
        )

    def _integral_rate(self, view: MotionView, distance_m: float, push: Vec2) -> Vec2:
        """Return q' (m; NED): the position error near the path, otherwise zero."""
        if view.path is None or distance_m > self._params.integral_zone_m or push != (0.0, 0.0):
            return 0.0, 0.0
        wanted, actual = view.path.position, view.nav.position
        return wanted[0] - actual[0], wanted[1] - actual[1]
