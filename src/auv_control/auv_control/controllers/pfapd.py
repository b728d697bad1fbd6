"""
Potential-function augmented PD path following in the horizontal plane, thesis Eqs. (2.35)-(2.38).

    tau = M nu_r' + C(nu) nu_r + K_p eta_e + K_v nu_e + F_rep

that is `pfpd` plus a feed-forward along the path. C(nu) is the thesis's (2.24), which includes the drag:
d(nu) nu_r with d(a) = d_L + d_Q |a| (`drag: abs`) or d_L + d_Q a (`drag: thesis`). The drag matters most: the
better it is known, the smaller the steady error of `pfpd` becomes (`damping_scale` shows this).

Deviation: the feed-forward has no yaw component, as the thesis's vehicle has no yaw moment; with yaw gains
the moment is K_p psi_e + K_v r_e alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from auv_control.controllers import MotionView, pfpd
from auv_control.tracking_errors import TrackingErrors, tracking_errors
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param

Vec2 = tuple[float, float]


@dataclass(frozen=True)
class Params(pfpd.Params):
    """
    Gains as for `pfpd`, and the law's model of the vehicle in surge and sway: by default Table 2.1.
    """

    inertia: Vec2 = param("masses m11 and m22 with added mass (kg)", default=(215.0, 265.0), above=0.0)
    linear_damping: Vec2 = param("linear damping d_L (N s/m)", default=(70.0, 100.0), minimum=0.0)
    quadratic_damping: Vec2 = param("quadratic damping d_Q (N s^2/m^2)", default=(100.0, 200.0), minimum=0.0)
    drag: str = param(
        "quadratic term with |a|, or with a as the thesis prints it", default="abs", choices=("abs", "thesis")
    )
    damping_scale: float = param("factor on the damping in the feed-forward", default=1.0, minimum=0.0)


class Controller(pfpd.Controller):
    """The law; it has no state."""

    proof_gap = (
        "(2.47) assumes that obstacles remove energy, although nu_e^T F_rep may have either sign, and that "
        "M' - 2C is skew-symmetric, although m11 differs from m22 in its off-diagonals; in the body frame, "
        "which the thesis leaves out, unequal gains in surge and sway add r (K_x - K_y) x_e y_e to V', and "
        "yaw is not controlled"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        super().__init__(params, period_s)
        self._model = params
        self._is_printed_drag = params.drag == "thesis"

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; in the frame's axes) and the rate of the empty state."""
        errors = tracking_errors(view, self._frame)
        x, y, n = self._feedback(errors)
        fx, fy = self._repulsion(view)
        ax, ay = self._feed_forward(errors, view.nav.nu)
        return (x + ax + fx, y + ay + fy, 0.0, 0.0, 0.0, n), state

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """
        Return the values of the candidates (J).

        thesis : (2.42), eta_e^T K_p eta_e / 2 + nu_e^T M nu_e / 2 with the free yaw rate in it.
        corrected : see `pfpd.Controller.corrected_candidate`.
        """
        del state
        errors = tracking_errors(view, self._frame)
        u_e, v_e, r_e = errors.velocity
        return (
            self._spring_energy(errors.pose) + kinetic_energy((u_e, v_e, 0.0, 0.0, 0.0, r_e)),
            self.corrected_candidate(view, kinetic_energy),
        )

    def _feed_forward(self, errors: TrackingErrors, nu: Vec6) -> tuple[float, float]:
        """Return the surge and sway forces of M nu_r' + C(nu) nu_r (N), thesis Eqs. (2.24) and (2.35)."""
        p = self._model
        m11, m22 = p.inertia
        u_r, v_r, _ = errors.reference
        u, v, r = nu[0], nu[1], nu[5]
        if not self._is_printed_drag:
            u, v = abs(u), abs(v)
        surge = p.damping_scale * (p.linear_damping[0] + p.quadratic_damping[0] * u)
        sway = p.damping_scale * (p.linear_damping[1] + p.quadratic_damping[1] * v)
        return (
            m11 * errors.reference_rate[0] - m22 * r * v_r + surge * u_r,
            m22 * errors.reference_rate[1] + m11 * r * u_r + sway * v_r,
        )
