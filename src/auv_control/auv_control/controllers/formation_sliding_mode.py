"""
Sliding mode for a group in formation, for the future work of thesis Section 7.3.

The path point of `auv_control.formation` replaces the vehicle's own. With e = eta - eta_t (NED), the virtual
reference eta_r' = eta_t' - lambda e, nu_r = J^T eta_r', s = nu - nu_r and the law's model (hats),

    tau = M^ nu_r' + C^(nu) nu_r + D^(nu) nu_r - k sat(s / phi)

With V = s^T M s / 2 and the model error delta, which has the motion of the neighbours in it,

    V' = -s^T D(nu) s - s^T k sat(s / phi) + s^T delta

so that V decreases wherever |s_i| > phi_i, if k_i > |delta_i|. Within the layer the law is the corrected law
of chapter 3 (`adaptive`) with K_D = k / phi and fixed parameters: the defaults have the same K_D and lambda.

Deviation: the rate of the shift by the neighbours is unknown to the vehicle, which knows their positions
only; it is part of delta.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from auv_control.body_regressor import Vec4, body_forces
from auv_control.controllers import MotionLaw, MotionView
from auv_control.formation import FormationParams, blend_start, limited_wrench, motion_about_target
from auv_control.path_motion import virtual_motion
from auv_core.geometry import clipped
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param


@dataclass(frozen=True)
class Params(FormationParams):
    """Gains in the order surge, sway, heave, yaw."""

    error_rate_ps: Vec4 = param(
        "rate lambda at which an error decays on s = 0 (1/s)", default=(0.5, 0.5, 0.5, 0.5), above=0.0
    )
    switching_gain: Vec4 = param(
        "k, the largest disturbance that is rejected (N, N m)", default=(40.0, 40.0, 60.0, 12.0), above=0.0
    )
    boundary_layer: Vec4 = param(
        "half width phi of the layer (m/s, rad/s)", default=(0.2, 0.2, 0.2, 0.2), above=0.0
    )


class Controller(MotionLaw):
    """The law of one vehicle; its state is the start of the blend."""

    command = "wrench"
    follows = "path"
    candidates = ("sliding",)
    shared_candidate = False
    proof_gap = (
        "not a law of the thesis; V always decreases with the vehicle's true parameters in still water, "
        "continuous time and without coupling, otherwise only outside the boundary layer and while k exceeds "
        "the disturbance by neighbours, wrong parameters, current, noise, sampling and actuator limits"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params

    def initial_state(self, view: MotionView) -> State:
        """Return the start of the blend."""
        return blend_start(view, self._params)

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; body) and the rate of the state: zeros."""
        p = self._params
        nu, nu_r, nu_r_rate = virtual_motion(motion_about_target(view, p, state), p.error_rate_ps)
        x, y, z, n = body_forces(p.model, nu, nu_r, nu_r_rate)
        k, phi = p.switching_gain, p.boundary_layer
        kx, ky, kz, kn = [k[i] * clipped((nu[i] - nu_r[i]) / phi[i], 1.0) for i in range(4)]
        wrench, _ = limited_wrench((x - kx, y - ky, z - kz, n - kn), p.max_force_n)
        return wrench, (0.0,) * len(state)

    def sliding_variable(self, state: State, view: MotionView) -> Vec4:
        """Return s of surge, sway, heave (m/s) and yaw (rad/s)."""
        p = self._params
        nu, nu_r, _ = virtual_motion(motion_about_target(view, p, state), p.error_rate_ps)
        return nu[0] - nu_r[0], nu[1] - nu_r[1], nu[2] - nu_r[2], nu[3] - nu_r[3]

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """Return s^T M s / 2 (J)."""
        x, y, z, n = self.sliding_variable(state, view)
        return (kinetic_energy((x, y, z, 0.0, 0.0, n)),)
