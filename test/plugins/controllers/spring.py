"""Spring and damper towards the path."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import body_to_ned, ned_to_body
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Stiffness and damping."""

    stiffness_npm: float = param("force per position error (N/m)", default=80.0, above=0.0)
    damping_nspm: float = param("force per velocity error (N s/m)", default=200.0, above=0.0)


class Controller:
    """X, Y, Z from position and velocity errors in NED; no moments."""

    command = "wrench"
    follows = "path"
    candidates = ("energy",)
    shared_candidate = False
    proof_gap = "the path moves and the drag does work"

    def __init__(self, params, period_s):
        self._params = params

    def initial_state(self, view):
        """Return nothing to remember."""
        return ()

    def constrained(self, state):
        """Return `state` itself."""
        return state

    def evaluate(self, state, view):
        """Return the wrench (N; body) and no rates."""
        velocity = body_to_ned(view.nav.attitude, view.nav.nu[:3])
        p = self._params
        nav, path = view.nav, view.path
        force = tuple(
            p.stiffness_npm * (path.position[i] - nav.position[i])
            + p.damping_nspm * (path.velocity[i] - velocity[i])
            for i in range(3)
        )
        return (*ned_to_body(view.nav.attitude, force), 0.0, 0.0, 0.0), ()

    def lyapunov(self, state, view, kinetic_energy):
        """Return spring and kinetic energy (J)."""
        stretch_m2 = sum((xd - x) ** 2 for x, xd in zip(view.nav.position, view.path.position, strict=False))
        return (0.5 * self._params.stiffness_npm * stretch_m2 + kinetic_energy(view.nav.nu),)
