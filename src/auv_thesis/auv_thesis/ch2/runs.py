"""Runs of chapter 2, and their curves as in the thesis: errors are reference minus actual."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from auv_experiment.metrics import path as metrics_path
from auv_experiment.recording import FloatArray
from auv_thesis.items import Run, RunSpec

PD, APD = RunSpec("ch2_pfpd"), RunSpec("ch2_pfapd")
PD_OBSTACLES, APD_OBSTACLES = RunSpec("ch2_pfpd_obstacles"), RunSpec("ch2_pfapd_obstacles")
PD_BODY, APD_BODY = RunSpec("ch2_pfpd_corrected"), RunSpec("ch2_pfapd_corrected")
PD_BODY_OBSTACLES = RunSpec("ch2_pfpd_obstacles_corrected")
APD_BODY_OBSTACLES = RunSpec("ch2_pfapd_obstacles_corrected")

FIRST_OBSTACLE_ONLY = "environment.obstacles=[{position_ned_m: [8.0, 5.0, 0.0], safety_distance_m: 2.0}]"
PD_ONE_OBSTACLE = RunSpec("ch2_pfpd_obstacles", (FIRST_OBSTACLE_ONLY,))
APD_ONE_OBSTACLE = RunSpec("ch2_pfapd_obstacles", (FIRST_OBSTACLE_ONLY,))

LAW = "agent.controller.params"
COARSE = "dt_s=0.1"
"""A step that keeps four digits unchanged, for runs whose curves are not shown."""
FROM_60_DEGREES = f"vehicles.0.heading_rad={math.pi / 3.0:.6f}"
PLANT_DRAG = "vehicles.0.model.params.drag=abs"
PD_ABS = RunSpec("ch2_pfpd", (PLANT_DRAG, COARSE))
APD_ABS = RunSpec("ch2_pfapd", (PLANT_DRAG, f"{LAW}.drag=abs", COARSE))
PD_60 = RunSpec("ch2_pfpd_corrected", (FROM_60_DEGREES, COARSE))
APD_60 = RunSpec("ch2_pfapd_corrected", (FROM_60_DEGREES, COARSE))
PD_ABS_OBSTACLES = RunSpec("ch2_pfpd_obstacles", (PLANT_DRAG, COARSE))
APD_ABS_OBSTACLES = RunSpec("ch2_pfapd_obstacles", (PLANT_DRAG, f"{LAW}.drag=abs", COARSE))
MIXED = RunSpec("ch2_pfpd_corrected", (f"{LAW}.frame=mixed", FROM_60_DEGREES, COARSE))
MIXED_NORTH = RunSpec("ch2_pfpd_corrected", (f"{LAW}.frame=mixed", COARSE))
DAMPING_SCALES = (0.5, 0.8, 1.2, 1.5)
SCALED = tuple(RunSpec("ch2_pfapd_corrected", (f"{LAW}.damping_scale={s}", COARSE)) for s in DAMPING_SCALES)
READING_S = 33.0
GAIN_SETS = tuple((k_u, k_v) for k_u in (40.0, 50.0, 60.0) for k_v in (40.0, 50.0, 60.0))
GAIN_RUNS = tuple(
    RunSpec("ch2_pfpd", (f"{LAW}.velocity_gain=[{k_u}, {k_v}, 0.0]",), READING_S) for k_u, k_v in GAIN_SETS
)
FAR_START = "vehicles.0.position_ned_m=[0.0, 11.3, 0.0]"
PRINTED_DRAG_FAR = RunSpec("ch2_pfpd", (FAR_START,), READING_S)
REAL_DRAG_FAR = RunSpec("ch2_pfpd", (FAR_START, PLANT_DRAG), READING_S)

HEADINGS_DEG = (0, 10, 20, 30, 45, 60)
MIXED_FROM = tuple(
    RunSpec(
        "ch2_pfpd_corrected",
        (f"{LAW}.frame=mixed", f"vehicles.0.heading_rad={math.radians(degrees):.6f}", COARSE),
        keep_recording=False,
    )
    for degrees in HEADINGS_DEG
)
"""PD with NED errors as body forces, from several headings."""

PAST_S = 220.0
OFFSETS_M = (-1.0, -0.4, -0.2, 0.0, 0.2, 0.4, 1.0)
"""Places of an obstacle beside the path, outwards (m)."""
_BEARING_RAD = math.atan2(8.0, 5.0)


def _obstacle_at(offset_m: float) -> str:
    radius_m = 10.0 + offset_m
    place = [round(radius_m * math.sin(_BEARING_RAD), 4), round(radius_m * math.cos(_BEARING_RAD), 4), 0.0]
    return f"environment.obstacles=[{{position_ned_m: {place}, safety_distance_m: 2.0}}]"


BESIDE = tuple(
    RunSpec(spec.scenario, (_obstacle_at(offset_m), COARSE), PAST_S, keep_recording=False)
    for spec in (PD_BODY_OBSTACLES, APD_BODY_OBSTACLES)
    for offset_m in OFFSETS_M
)
"""Both laws past one obstacle on the path or beside it."""

STARTS = 10
STARTS_SEED = 2
_STARTS_S = 100.0


def _drawn_starts() -> list[tuple[str, str]]:
    """Return overrides for starts within 5 m of the origin along each axis, with any heading."""
    rng = np.random.default_rng(STARTS_SEED)
    drawn = rng.uniform((-5.0, -5.0, -math.pi), (5.0, 5.0, math.pi), (STARTS, 3)).round(3).tolist()
    return [
        (f"vehicles.0.position_ned_m=[{x}, {y}, 0.0]", f"vehicles.0.heading_rad={heading}")
        for x, y, heading in drawn
    ]


FROM_STARTS = tuple(
    RunSpec(spec.scenario, (*start, COARSE), _STARTS_S, keep_recording=False)
    for spec in (PD_BODY, APD_BODY)
    for start in _drawn_starts()
)
"""PD, then augmented PD, from the same drawn starts."""


def settling_s(t_s: FloatArray, sizes: FloatArray, band: float, until_s: float = math.inf) -> float | None:
    """Return the first time after which `sizes` (K,) stays below `band` until `until_s` (s), or None."""
    is_out = sizes[t_s < until_s] >= band
    if is_out[-1]:
        return None
    return float(t_s[np.flatnonzero(is_out)[-1] + 1]) if is_out.any() else float(t_s[0])


@dataclass(frozen=True, eq=False)
class Curves:
    """
    Curves of the first vehicle of a run over its K + 1 records.

    Attributes
    ----------
    t_s : (K + 1,) array
    pose, path : (K + 1, 3) arrays
        x and y (m, NED), psi (rad), of the vehicle and of the path.
    velocity, path_velocity : (K + 1, 3) arrays
        Rates of x and y (m/s, NED) and of psi (rad/s).

    """

    t_s: FloatArray
    pose: FloatArray
    path: FloatArray
    velocity: FloatArray
    path_velocity: FloatArray

    @property
    def pose_error(self) -> FloatArray:
        """Path minus vehicle (m, m, rad)."""
        error = self.path - self.pose
        error[:, 2] = np.angle(np.exp(1j * error[:, 2]))
        return error

    @property
    def distance_m(self) -> FloatArray:
        """Distance to the path (K + 1,) (m)."""
        return np.hypot(*self.pose_error[:, :2].T)

    @property
    def largest_velocity_error_mps(self) -> FloatArray:
        """The larger of |u_e| and |v_e| (K + 1,) (m/s)."""
        return np.abs(self.velocity_error[:, :2]).max(axis=1)

    @property
    def velocity_error(self) -> FloatArray:
        """Path minus vehicle (m/s, m/s, rad/s)."""
        return self.path_velocity - self.velocity


def curves(run: Run) -> Curves:
    """Return the curves of a run."""
    recording, scenario = run.recording, run.scenario
    points, rates = metrics_path.path_points_ned(recording, scenario)
    path = scenario.reference_of(0)
    if path is None:
        raise ValueError(f"{scenario.name}: no path")
    along = [path.at(t) for t in recording.t_s.tolist()]
    headings = [point.heading_rad for point in along]
    turns = [point.heading_rate_radps for point in along]
    ned_mps = metrics_path.velocity_ned_mps(recording, scenario)[:, 0, :2]
    return Curves(
        recording.t_s,
        np.column_stack([recording.position_ned_m[:, 0, :2], metrics_path.heading_rad(recording)[:, 0]]),
        np.column_stack([points[:, 0, :2], headings]),
        np.column_stack([ned_mps, recording.velocity_body[:, 0, 5]]),
        np.column_stack([rates[:, 0, :2], turns]),
    )
