"""
H-infinity control for a group in formation, for the future work of thesis Section 7.3.

The path point of `auv_control.formation` replaces the vehicle's own. Errors are reference minus actual, x =
[q, e, nu_e] along surge, sway, heave and yaw, where q is the integral of e, kept in NED. The law is

    tau = M nu_t' + C(nu) nu_t + D(nu) nu_t + F x,      nu_t = J^T eta_t'

F keeps the worst gain from a disturbing force to errors and effort below gamma, for the model linearised
about the path. F, the solution P of its Riccati equation, gamma and the achieved norm come from
`./scripts/synthesise_h_infinity`; the numbers here and in the preset ``formation_h_infinity_table_3_1`` are
for thesis Table 3.1, and F_e is the stiffness K_D lambda of `adaptive` and `formation_sliding_mode`.

A linear law is valid for small errors. Position errors are limited to `error_limit_m`. q is integrated only
within `integral_zone_m` of the path point and while no force is at its limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from auv_control.body_regressor import Vec4, body_forces
from auv_control.controllers import MotionLaw, MotionView
from auv_control.formation import FormationParams, blend_start, limited_wrench, motion_about_target
from auv_control.path_motion import Motion, virtual_motion
from auv_control.riccati import check_feedback, check_norms, quadratic
from auv_core.geometry import Vec3, limited
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param

AXES = ("surge", "sway", "heave", "yaw")
_ON_THE_PATH: Vec4 = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Params(FormationParams):
    """Feedback with the certificate of its norm."""

    surge_gain: Vec3 = param(
        "F of surge: on q, e and nu_e (N/(m s), N/m, N s/m)", default=(12.5, 100.0, 143.85768), minimum=0.0
    )
    sway_gain: Vec3 = param(
        "F of sway: on q, e and nu_e (N/(m s), N/m, N s/m)", default=(12.5, 100.0, 122.62847), minimum=0.0
    )
    heave_gain: Vec3 = param(
        "F of heave: on q, e and nu_e (N/(m s), N/m, N s/m)", default=(12.5, 150.0, 219.01144), minimum=0.0
    )
    yaw_gain: Vec3 = param(
        "F of yaw: on q, e and nu_e (N m/(rad s), N m/rad, N m s/rad)",
        default=(3.75, 30.0, 70.833397),
        minimum=0.0,
    )
    surge_riccati: Vec6 = param(
        "upper triangle of P of surge, by rows (per m s, m, m/s)",
        default=(0.5, 1.4892328, 1.375, 10.538863, 11.0, 15.824345),
    )
    sway_riccati: Vec6 = param(
        "upper triangle of P of sway, by rows (per m s, m, m/s)",
        default=(0.5, 1.739309, 1.5069444, 12.407528, 12.055556, 14.783543),
    )
    heave_riccati: Vec6 = param(
        "upper triangle of P of heave, by rows (per m s, m, m/s)",
        default=(0.75, 1.8650016, 1.7569444, 20.623075, 21.083333, 30.783274),
    )
    yaw_riccati: Vec6 = param(
        "upper triangle of P of yaw, by rows (per rad s, rad, rad/s)",
        default=(0.5, 1.2667483, 1.3472222, 8.7867641, 10.777778, 25.447554),
    )
    gamma: Vec4 = param(
        "gain gamma of the Riccati equations, surge to yaw",
        default=(0.83333333, 0.83333333, 0.83333333, 0.83333333),
        above=0.0,
    )
    achieved_norm: Vec4 = param(
        "H-infinity norm of the closed loops, surge to yaw",
        default=(0.78818427, 0.78993929, 0.78413755, 0.79401781),
        above=0.0,
    )
    error_limit_m: float = param("limit of position errors (m)", default=0.6, above=0.0)
    integral_zone_m: float = param(
        "distance to the path point within which q is integrated (m)", default=0.5, minimum=0.0
    )

    def __post_init__(self) -> None:
        hulls = zip(self.inertia, self.linear_damping, strict=True)
        for name, gain, riccati, hull in zip(AXES, self.gains, self.riccatis, hulls, strict=True):
            check_feedback(name, gain, riccati, hull)
        check_norms(self.achieved_norm, self.gamma)

    @property
    def gains(self) -> tuple[Vec3, Vec3, Vec3, Vec3]:
        """F of the four axes."""
        return self.surge_gain, self.sway_gain, self.heave_gain, self.yaw_gain

    @property
    def riccatis(self) -> tuple[Vec6, Vec6, Vec6, Vec6]:
        """Upper triangles of P of the four axes."""
        return self.surge_riccati, self.sway_riccati, self.heave_riccati, self.yaw_riccati


class Controller(MotionLaw):
    """The law of one vehicle; its state is q (m s, rad s; NED) and the start of the blend."""

    command = "wrench"
    follows = "path"
    candidates = ("quadratic",)
    shared_candidate = False
    proof_gap = (
        "not a law of the thesis; x^T P x decreases for the linearised model on a path without coupling, but "
        "not always with limited errors, nonlinear drag, a turning hull, wrong parameters, neighbours that "
        "move the path point, current, noise or actuator limits"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params

    def initial_state(self, view: MotionView) -> State:
        """Return q = 0 and the start of the blend."""
        return (0.0, 0.0, 0.0, 0.0, *blend_start(view, self._params))

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; body) and the rate of the state."""
        p = self._params
        motion = motion_about_target(view, p, state[4:])
        nu, nu_t, nu_t_rate = virtual_motion(motion, _ON_THE_PATH)
        forces = body_forces(p.model, nu, nu_t, nu_t_rate)
        x, y, z, n = [
            force + gain[0] * q + gain[1] * e + gain[2] * nu_e
            for force, gain, (q, e, nu_e) in zip(
                forces, p.gains, _axes(state, motion, p.error_limit_m), strict=True
            )
        ]
        wrench, is_cut = limited_wrench((x, y, z, n), p.max_force_n)
        ex, ey, ez, en = motion.error
        if is_cut or math.hypot(ex, ey, ez) > p.integral_zone_m:
            return wrench, (0.0,) * len(state)
        return wrench, (-ex, -ey, -ez, -en, *(0.0,) * (len(state) - 4))

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """Return the sum of x^T P x over the axes (1, as the synthesis weighs x)."""
        motion = motion_about_target(view, self._params, state[4:])
        axes = _axes(state, motion, math.inf)
        return (sum(quadratic(p, x) for p, x in zip(self._params.riccatis, axes, strict=True)),)


def _axes(state: State, motion: Motion, error_limit_m: float) -> tuple[Vec3, Vec3, Vec3, Vec3]:
    """Return x = [q, e, nu_e] of surge, sway, heave and yaw, with position errors of limited length."""
    nu, nu_t, _ = virtual_motion(motion, _ON_THE_PATH)
    ex, ey, ez = limited((-motion.error[0], -motion.error[1], -motion.error[2]), error_limit_m)
    c, s = motion.cosine, motion.sine
    qx, qy, qz, qn = state[:4]
    return (
        (c * qx + s * qy, c * ex + s * ey, nu_t[0] - nu[0]),
        (c * qy - s * qx, c * ey - s * ex, nu_t[1] - nu[1]),
        (qz, ez, nu_t[2] - nu[2]),
        (qn, -motion.error[3], nu_t[3] - nu[3]),
    )
