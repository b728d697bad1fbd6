"""
H-infinity control under a flocking law, for the future work of thesis Section 7.3: state feedback with
integral action on the velocity over ground, PD on the attitude.

Along each axis x = [q, nu_e] with the velocity error nu_e and its integral q (kept in NED), and

    tau = D^(nu) nu_w + F x

for the commanded velocity nu_w and the model's drag. F keeps the worst gain from a disturbing force to x and
effort below gamma, for the model linearised about a steady speed. F, the solution P of its Riccati equation,
gamma and the achieved norm come from `./scripts/synthesise_h_infinity`; the numbers here and in the preset
``velocity_h_infinity_odin`` are for ODIN, whose axes are equal.

A hull without lag of its actuators has one state along each axis. Its H-infinity state feedback with integral
action is therefore a PI controller: the synthesis chooses its two gains and certifies the norm. F_nu is the
300 N s/m of `velocity_pi`, so that the bandwidths are equal.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.velocity_loop import LoopParams, VelocityLoop
from auv_core.geometry import Vec3
from auv_core.params import param

Vec2 = tuple[float, float]


@dataclass(frozen=True)
class Params(LoopParams):
    """Feedback with the certificate of its norm."""

    gain: Vec2 = param("F on q and nu_e (N/m, N s/m)", default=(62.5, 300.0), above=0.0)
    riccati: Vec3 = param("upper triangle of P, by rows (per m, m/s)", default=(8.1666667, 13.020833, 62.5))
    gamma: float = param("gain gamma of the Riccati equation", default=0.83333333, above=0.0)
    achieved_norm: float = param("H-infinity norm of the closed loop", default=0.78469144, above=0.0)

    def __post_init__(self) -> None:
        a, b, c = self.riccati
        if not (a > 0.0 and a * c > b * b):
            raise ValueError(
                f"riccati: {list(self.riccati)!r} is not allowed; allowed: a positive definite matrix"
            )
        if self.achieved_norm > self.gamma:
            raise ValueError(
                f"achieved_norm: {self.achieved_norm!r} is not allowed; "
                f"allowed: at most gamma = {self.gamma!r}"
            )


class Controller(VelocityLoop):
    """The law of one vehicle; its state is q (m; NED)."""

    def __init__(self, params: Params, period_s: float) -> None:
        super().__init__(params, period_s)
        self._params = params

    def force(self, axis: int, actual_mps: float, wanted_mps: float, held_m: float) -> float:
        """Return the force along one axis before its limit (N; body)."""
        p = self._params
        drag = p.drag_factor(axis, actual_mps) * wanted_mps
        return drag + p.gain[0] * held_m + p.gain[1] * (wanted_mps - actual_mps)
