"""Dead reckoning: compass, velocity log and pressure sensor with errors, and optional position fixes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import body_to_ned, quaternion_from_heading, quaternion_product
from auv_core.messages import VehicleState
from auv_core.odom_frame import OdomFrame
from auv_core.params import param
from auv_sim.navigation import OwnNavigation
from auv_sim.navigation._drift import Drift
from auv_sim.streams import Purpose, generator, uniform

_BLOCK_TICKS = 64
_SLACK_FIXES = 1e-6


@dataclass(frozen=True)
class Params:
    """Errors of the sensors, of the start, and of the fixes."""

    velocity_bias_mps: float = param(
        "magnitude of the log's constant error, in the body's horizontal plane (m/s)",
        default=0.01,
        minimum=0.0,
        maximum=10.0,
    )
    velocity_sd_mps: float = param(
        "white noise of the log, per body axis and control period (m/s)",
        default=0.02,
        minimum=0.0,
        maximum=10.0,
    )
    heading_bias_rad: float = param(
        "magnitude of the compass's constant error (rad)", default=math.radians(0.5), minimum=0.0, maximum=1.0
    )
    depth_sd_m: float = param(
        "white noise of the depth, per control period (m)", default=0.01, minimum=0.0, maximum=100.0
    )
    start_sd_m: float = param(
        "error of the start, per horizontal axis (m)", default=0.0, minimum=0.0, maximum=1000.0
    )
    fix: str = param(
        "source of position fixes: none, surface (only near the surface), lbl (anywhere)",
        default="none",
        choices=("none", "surface", "lbl"),
    )
    fix_period_s: float = param("time between fixes (s)", default=60.0, minimum=1e-3)
    fix_sd_m: float = param(
        "error of a fix, per horizontal axis (m)", default=0.3, minimum=0.0, maximum=1000.0
    )
    surface_depth_m: float = param("deepest surface fix (m)", default=0.5, minimum=0.0)
    learns_biases: bool = param(
        "whether fixes also correct the constant errors of log and compass", default=False
    )


class Navigation(OwnNavigation):
    """
    The position is the start plus the integral of the log's velocity, rotated by the compass; the depth is
    measured.

    * The log's constant error has the given magnitude and a random direction in the body's horizontal plane;
      the compass's has the given magnitude and a random sign. Both are fixed by (seed, address) for the whole
      run. With a magnitude instead of a standard deviation, every vehicle of every run drifts as much as the
      scenario says. The variance per axis is half the square of the log's magnitude, and the square of the
      compass's.
    * Roll, pitch and the turn rates are exact. The log measures velocity over ground. The integration adds
      no error: the drift is due to the sensors.
    * A fix comes in the tick that contains a multiple of its period; a `surface` fix comes as soon
      afterwards as the vehicle is shallow enough. Errors of fixes are independent; a fix takes neither time
      nor airtime.
    * `position_sd_m` (per horizontal axis; the depth is better) and `heading_sd_rad` are those of a Kalman
      filter that knows only the magnitudes above; see `Drift`.
    * `is_bounded` is true with `lbl` only: whether a vehicle comes up for a `surface` fix is not known here.
    * `velocity_sd_mps` (forward, right, down) includes the log's noise and its constant error, without
      corrections by fixes.
    """

    def __init__(self, params: Params, seed: int, address: int, period_s: float) -> None:
        self._params = params
        self._seed = seed
        self._address = address
        self._period_s = period_s
        direction_rad = 2.0 * math.pi * uniform(seed, Purpose.NAVIGATION, address, 0, 1)
        side = 1.0 if uniform(seed, Purpose.NAVIGATION, address, 0, 2) < 0.5 else -1.0
        self._surge_mps = params.velocity_bias_mps * math.cos(direction_rad)
        self._sway_mps = params.velocity_bias_mps * math.sin(direction_rad)
        self._turned_rad = side * params.heading_bias_rad
        self._drift = Drift(
            params.start_sd_m,
            params.heading_bias_rad,
            params.velocity_bias_mps / math.sqrt(2.0),
            learns=params.learns_biases,
        )
        self.odom_frame = OdomFrame()
        self.depth_sd_m = params.depth_sd_m
        level_mps = math.hypot(params.velocity_sd_mps, params.velocity_bias_mps / math.sqrt(2.0))
        self.velocity_sd_mps = (level_mps, level_mps, params.velocity_sd_mps)
        self._block = -1
        self._noise: list[tuple[float, float, float, float]] = []
        self._truth: VehicleState | None = None
        self._north_m = self._east_m = 0.0
        self._fixes_due = 0

    def measured(self, state: VehicleState) -> VehicleState:
        """Return the vehicle's navigation for the true `state`; ticks must increase."""
        p = self._params
        noise = self._normals(state.tick)
        attitude = quaternion_product(quaternion_from_heading(self._turned_rad), state.attitude)
        off_mps = (
            self._surge_mps + p.velocity_sd_mps * noise[0],
            self._sway_mps + p.velocity_sd_mps * noise[1],
            p.velocity_sd_mps * noise[2],
        )
        if self._truth is None:
            self._start(state)
        else:
            self._advance(self._truth, state, body_to_ned(attitude, off_mps), attitude)
        self._truth = state
        if p.fix != "none" and self._takes_fix(state):
            self._fix(state)
            attitude = quaternion_product(quaternion_from_heading(self._turned_rad), state.attitude)
        u, v, w, roll, pitch, yaw = state.nu
        return VehicleState(
            state.tick,
            (self._north_m, self._east_m, state.position[2] + p.depth_sd_m * noise[3]),
            attitude,
            (u + off_mps[0], v + off_mps[1], w + off_mps[2], roll, pitch, yaw),
            position_sd_m=math.sqrt(max(self._drift.position_variance_m2, 0.0)),
            heading_sd_rad=math.sqrt(self._drift.heading_variance_rad2),
            is_bounded=p.fix == "lbl",
        )

    def _start(self, state: VehicleState) -> None:
        off = generator(self._seed, Purpose.FIX, self._address, 0).standard_normal(2).tolist()
        self._north_m = state.position[0] + self._params.start_sd_m * off[0]
        self._east_m = state.position[1] + self._params.start_sd_m * off[1]
        self._fixes_due = self._fixes_until(state.tick)

    def _advance(
        self,
        before: VehicleState,
        state: VehicleState,
        off_ned_mps: tuple[float, float, float],
        attitude: tuple[float, float, float, float],
    ) -> None:
        """Add the true displacement, rotated by the compass's error, and the effect of the log's error."""
        dt_s = (state.tick - before.tick) * self._period_s
        north_m, east_m = state.position[0] - before.position[0], state.position[1] - before.position[1]
        c, s = math.cos(self._turned_rad), math.sin(self._turned_rad)
        moved_m = (
            c * north_m - s * east_m + dt_s * off_ned_mps[0],
            s * north_m + c * east_m + dt_s * off_ned_mps[1],
        )
        self._north_m += moved_m[0]
        self._east_m += moved_m[1]
        w, x, y, z = attitude
        axes = (
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
        )
        self._drift.advance(moved_m, axes, dt_s, dt_s * self._params.velocity_sd_mps)

    def _takes_fix(self, state: VehicleState) -> bool:
        p = self._params
        due = self._fixes_until(state.tick)
        if due == self._fixes_due or (p.fix == "surface" and state.position[2] > p.surface_depth_m):
            return False
        self._fixes_due = due
        return True

    def _fixes_until(self, tick: int) -> int:
        """Count the fixes before the next tick."""
        return math.ceil((tick + 1) * self._period_s / self._params.fix_period_s - _SLACK_FIXES)

    def _fix(self, state: VehicleState) -> None:
        sd_m = self._params.fix_sd_m
        off = generator(self._seed, Purpose.FIX, self._address, state.tick).standard_normal(2).tolist()
        north_m, east_m = state.position[0] + sd_m * off[0], state.position[1] + sd_m * off[1]
        fix = self._drift.correct((north_m - self._north_m, east_m - self._east_m), sd_m)
        self.odom_frame = self.odom_frame.corrected(
            (self._north_m, self._east_m), (fix.north_m, fix.east_m), -fix.heading_rad
        )
        self._north_m += fix.north_m
        self._east_m += fix.east_m
        self._turned_rad -= fix.heading_rad
        self._surge_mps -= fix.surge_mps
        self._sway_mps -= fix.sway_mps

    def _normals(self, tick: int) -> tuple[float, float, float, float]:
        """Return four normal numbers, fixed by seed, address and tick; drawn for many ticks at once."""
        block = tick // _BLOCK_TICKS
        if block != self._block:
            rng = generator(self._seed, Purpose.NAVIGATION, self._address, block)
            self._noise = [(a, b, c, d) for a, b, c, d in rng.standard_normal((_BLOCK_TICKS, 4)).tolist()]
            self._block = block
        return self._noise[tick % _BLOCK_TICKS]
