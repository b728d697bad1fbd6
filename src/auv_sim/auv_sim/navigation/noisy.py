"""White noise on position and velocity, drawn for every tick, and failed measurements."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.messages import VehicleState
from auv_core.odom_frame import OdomFrame
from auv_core.params import param
from auv_sim.navigation import OwnNavigation
from auv_sim.streams import Purpose, generator


@dataclass(frozen=True)
class Params:
    """Standard deviations per axis; the attitude is measured exactly."""

    position_sd_m: float = param(
        "standard deviation of a position, per NED axis (m)", default=0.05, minimum=0.0, maximum=100.0
    )
    velocity_sd_mps: float = param(
        "standard deviation of a velocity, per body axis (m/s)", default=0.01, minimum=0.0, maximum=10.0
    )
    failure_prob: float = param(
        "probability that a tick has no measurement", default=0.0, minimum=0.0, maximum=1.0
    )


class Navigation(OwnNavigation):
    """Noise by (seed, address, tick): the number of vehicles does not change it."""

    odom_frame = OdomFrame()

    def __init__(self, params: Params, seed: int, address: int, period_s: float) -> None:
        del period_s
        self._params = params
        self._seed = seed
        self._address = address
        self.depth_sd_m = params.position_sd_m
        self.velocity_sd_mps = (params.velocity_sd_mps,) * 3
        self._last: VehicleState | None = None

    def measured(self, state: VehicleState) -> VehicleState:
        """Return `state` with noise; if the measurement fails, return the last one, marked as not valid."""
        p = self._params
        rng = generator(self._seed, Purpose.NAVIGATION, self._address, state.tick)
        if rng.random() < p.failure_prob:
            last = state if self._last is None else self._last
            return last._replace(tick=state.tick, is_valid=False)
        (x, y, z), (u, v, w) = rng.standard_normal((2, 3)).tolist()
        position: Vec3 = (
            state.position[0] + p.position_sd_m * x,
            state.position[1] + p.position_sd_m * y,
            state.position[2] + p.position_sd_m * z,
        )
        sd_mps = p.velocity_sd_mps
        nu = (state.nu[0] + sd_mps * u, state.nu[1] + sd_mps * v, state.nu[2] + sd_mps * w, *state.nu[3:])
        self._last = VehicleState(
            state.tick, position, state.attitude, nu, position_sd_m=p.position_sd_m, is_bounded=True
        )
        return self._last
