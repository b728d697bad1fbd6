"""
Sliding mode under a flocking law, for the future work of thesis Section 7.3: integral sliding mode on the
velocity over ground, PD on the attitude.

With the commanded velocity nu_w (body), e = nu_w - nu, q the integral of e (kept in NED) and s = e + lambda
q, the law is, with its model of the hull (hats),

    tau = M^ lambda e + D^(nu) (nu_w + lambda q) + k sat(s / phi)

With V = s^T M s / 2 and the model error delta, which has current, Coriolis forces and the rate of nu_w in it,

    V' = -s^T D(nu) s - s^T k sat(s / phi) + s^T delta

so that |s| comes below phi if k > |delta|, and e decays at the rate lambda. The integral removes the error
that a steady delta leaves in the layer.

Within the layer the law is `velocity_pi` with K_p = k / phi + m lambda, K_i = lambda k / phi, and the model's
drag. The defaults give the 300 N s/m and 75 N/m of `velocity_pi` on ODIN's 187.5 kg.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.velocity_loop import LoopParams, VelocityLoop
from auv_core.geometry import Vec3, clipped
from auv_core.params import param


@dataclass(frozen=True)
class Params(LoopParams):
    """Gains along every axis."""

    error_rate_ps: float = param(
        "rate lambda at which an error decays on s = 0 (1/s)", default=0.31, above=0.0
    )
    switching_gain_n: float = param(
        "k, the largest disturbance that is rejected (N)", default=60.0, above=0.0
    )
    boundary_layer_mps: float = param("half width phi of the layer (m/s)", default=0.248, above=0.0)
    mass_kg: Vec3 = param(
        "mass with added mass along surge, sway and heave (kg)", default=(187.5, 187.5, 187.5), above=0.0
    )


class Controller(VelocityLoop):
    """The law of one vehicle; its state is q (m; NED)."""

    def __init__(self, params: Params, period_s: float) -> None:
        super().__init__(params, period_s)
        self._params = params

    def force(self, axis: int, actual_mps: float, wanted_mps: float, held_m: float) -> float:
        """Return the force along one axis before its limit (N; body)."""
        p = self._params
        error, led = wanted_mps - actual_mps, p.error_rate_ps * held_m
        layer = clipped((error + led) / p.boundary_layer_mps, 1.0)
        drag = p.drag_factor(axis, actual_mps) * (wanted_mps + led)
        return p.mass_kg[axis] * p.error_rate_ps * error + drag + p.switching_gain_n * layer
