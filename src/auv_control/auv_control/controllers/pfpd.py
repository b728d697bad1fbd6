"""
Potential-function PD path following in the horizontal plane, thesis Eqs. (2.17)-(2.22).

    tau = K_p eta_e + K_v nu_e + F_rep

with the errors of `auv_control.tracking_errors` (reference minus actual; surge, sway and yaw) and the force
of the obstacles of `auv_control.avoidance`. The depth is not controlled: heave, roll and pitch get no
command.

The thesis's gains have no yaw component, so its vehicle uses surge and sway forces and never steers; the
moment is zero unless a yaw gain is given. The thesis prints K_v = [40 50 0], but only [50 40 0], the default
here, gives its figures and the PD row of Table 2.2 to every printed digit.

On a moving path the law leaves an error of about drag / K_p, since it does not compensate the drag.

Deviation: `frame: flat` is what the thesis simulated and `mixed` what it prints; `body` rotates the errors
and the obstacle force into the axes along which the forces act.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from auv_control.avoidance import obstacle_force, obstacle_potential
from auv_control.controllers import MotionLaw, MotionView
from auv_control.tracking_errors import FRAMES, TrackingErrors, ned_force_in_frame, tracking_errors
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Gains in the order surge, sway, yaw, and the frame of the plant."""

    position_gain: Vec3 = param(
        "force per position error K_p (N/m, N/m, N m/rad)", default=(100.0, 150.0, 0.0), minimum=0.0
    )
    velocity_gain: Vec3 = param(
        "force per velocity error K_v (N s/m, N s/m, N m s/rad)", default=(50.0, 40.0, 0.0), minimum=0.0
    )
    frame: str = param("axes of errors and forces", default="body", choices=FRAMES)
    obstacle_gain_nm: float = param("factor on the obstacle potential (N m)", default=1.0, minimum=0.0)
    truncate_repulsion: bool = param(
        "whether to set the obstacle force to zero beyond the safety distance, where it attracts",
        default=False,
    )

    def __post_init__(self) -> None:
        """Refuse gains that do not draw the vehicle to the path."""
        for axis, gain in enumerate(self.position_gain[:2]):
            if gain <= 0.0:
                raise ValueError(
                    f"position_gain[{axis}]: {gain!r} is not allowed; allowed: a finite number above 0"
                )


class Controller(MotionLaw):
    """The law; it has no state."""

    command = "wrench"
    follows = "path"
    candidates = ("thesis", "corrected")
    shared_candidate = False
    proof_gap = (
        "(2.34) calls nu_r^T K_p eta_e, nu^T K_v nu_e and nu^T grad U negative definite, but none of them "
        "is; it assumes a skew-symmetric M' - 2C, although C has the drag and m11 differs from m22; K_p is "
        "singular in yaw; on a moving path the drag and the path's acceleration do work, and the error "
        "stays near drag / K_p"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        del period_s
        self._params = params
        self._frame = params.frame

    def initial_state(self, view: MotionView) -> State:
        """Return (): the law has no state."""
        del view
        return ()

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; in the frame's axes) and the rate of the empty state."""
        errors = tracking_errors(view, self._frame)
        x, y, n = self._feedback(errors)
        fx, fy = self._repulsion(view)
        return (x + fx, y + fy, 0.0, 0.0, 0.0, n), state

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """
        Return the values of the candidates (J).

        thesis : (2.28), eta_e^T K_p eta_e / 2 + nu^T M nu / 2.
        corrected : see `corrected_candidate`.
        """
        del state
        errors = tracking_errors(view, self._frame)
        return (
            self._spring_energy(errors.pose) + kinetic_energy(view.nav.nu),
            self.corrected_candidate(view, kinetic_energy),
        )

    def corrected_candidate(self, view: MotionView, kinetic_energy: Callable[[Vec6], float]) -> float:
        """
        Return eta_e^T K_p eta_e / 2 + nu_e^T M nu_e / 2 + U (J).

        The errors are those of the true frame (nu_e along the hull's axes in 'body' and 'mixed'), the
        obstacles' potential is included, and yaw enters only if a gain acts on it: without yaw control its
        term need not decrease.
        """
        p = self._params
        errors = tracking_errors(view, "body" if self._frame == "mixed" else self._frame)
        is_steered = p.position_gain[2] > 0.0
        u_e, v_e, r_e = errors.velocity
        kinetic = kinetic_energy((u_e, v_e, 0.0, 0.0, 0.0, r_e if is_steered else 0.0))
        potential = obstacle_potential(
            view.nav.position, view.obstacles, p.obstacle_gain_nm, truncate=p.truncate_repulsion
        )
        return self._spring_energy(errors.pose) + kinetic + potential

    def _spring_energy(self, pose: Vec3) -> float:
        k = self._params.position_gain
        return 0.5 * (k[0] * pose[0] ** 2 + k[1] * pose[1] ** 2 + k[2] * pose[2] ** 2)

    def _feedback(self, errors: TrackingErrors) -> Vec3:
        """Return K_p eta_e + K_v nu_e, thesis Eq. (2.17)."""
        k, d = self._params.position_gain, self._params.velocity_gain
        e, s = errors.pose, errors.velocity
        return (k[0] * e[0] + d[0] * s[0], k[1] * e[1] + d[1] * s[1], k[2] * e[2] + d[2] * s[2])

    def _repulsion(self, view: MotionView) -> tuple[float, float]:
        if not view.obstacles:
            return 0.0, 0.0
        p = self._params
        force = obstacle_force(
            view.nav.position, view.obstacles, p.obstacle_gain_nm, truncate=p.truncate_repulsion
        )
        return ned_force_in_frame(view, force, self._frame)
