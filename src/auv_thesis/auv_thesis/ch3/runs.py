"""Runs of chapter 3: the two formations, as printed and corrected, and single vehicles for its studies."""

from __future__ import annotations

import math

import numpy as np

from auv_experiment.metrics.formations.errors import errors
from auv_thesis.items import Run, RunSpec

CIRCLE, SPIRAL = RunSpec("ch3_circle"), RunSpec("ch3_spiral")
CIRCLE_CORRECTED, SPIRAL_CORRECTED = RunSpec("ch3_circle_corrected"), RunSpec("ch3_spiral_corrected")

FLAT, BODY = "frame: flat, coriolis: false", "frame: body"
FIXED = (
    "inertia_adaptation: [0, 0, 0, 0], linear_adaptation: [0, 0, 0, 0], quadratic_adaptation: [0, 0, 0, 0]"
)
GROUPED = "agent.controller.preset=adaptive_thesis_grouped_gamma"
FINE = ("dt_s=0.01", "period_s=0.01")
COARSE = ("dt_s=0.05", "period_s=0.5")
"""Larger steps that keep the settled motion of the printed law unchanged, with few records."""
CORRECTED_STEP = ("dt_s=0.1", "period_s=0.5")
"""The same for the corrected law, whose gains are lower."""


def alone(
    path: str = "circle",
    radius_m: float = 10.0,
    rate_radps: float = 0.01,
    *,
    model: str = FLAT,
    heading: str = "fixed",
) -> str:
    """Return the override that keeps one vehicle of Table 3.1 only, which starts at rest at the origin."""
    more = f", depth_m: 10.0, heading: {heading}" if path == "circle" else ""
    return (
        f"vehicles=[{{id: auv_1, model: {{preset: table_3_1, params: {{{model}}}}}, "
        f"position_ned_m: [0.0, 0.0, 0.0], reference: {{kind: {path}, "
        f"params: {{radius_m: {radius_m}, rate_radps: {rate_radps}{more}}}}}}}]"
    )


def law(words: str) -> str:
    """Return the override that replaces parameters of the law's preset."""
    return f"agent.controller.params={{{words}}}"


SPIRAL_ALONE = RunSpec("ch3_spiral", (alone("spiral"), *FINE), 60.0)
WIND_UP = tuple(
    RunSpec("ch3_circle", (alone(radius_m=30.0), law(f"initial_ratio: {ratio}"), *FINE), 30.0)
    for ratio in (1.0, 0.7)
)
CROSSING = RunSpec(
    "ch3_circle",
    (
        "vehicles.0.position_ned_m=[0.0, 16.0, 10.0]",
        "vehicles.1.position_ned_m=[0.0, 8.0, 10.0]",
        "vehicles.2.position_ned_m=[0.0, 28.0, 10.0]",
    ),
    30.0,
)
"""The first two vehicles start at each other's path, and each moves straight to its own."""

READINGS = {
    "as printed: J = I, forces and motion in NED": RunSpec("ch3_circle", (alone(), *FINE), 200.0),
    "initial estimates zero": RunSpec("ch3_circle", (alone(), law("initial_ratio: 0.0"), *FINE), 200.0),
    "GAM read masses first": RunSpec("ch3_circle", (alone(), GROUPED, *FINE), 200.0),
    "body frame with C(nu), forces rotated by J^T": RunSpec(
        "ch3_circle", (alone(model=BODY), law("frame: body"), *FINE), 200.0
    ),
    "body frame with C(nu), forces not rotated": RunSpec(
        "ch3_circle", (alone(model=BODY), law("frame: mixed"), *FINE), 200.0
    ),
}
"""Interpretations of the printed law, each with the first vehicle alone."""

RATIOS = (1.0, 0.7, 1.3, 0.0)
PRINTED_S, PRINTED_LATE_S = 1000.0, 650.0
CORRECTED_S, CORRECTED_LATE_S = 600.0, 300.0


def printed_runs(ratio: float) -> tuple[RunSpec, ...]:
    """Return the circle (fixed, adaptive) and the spiral (fixed, adaptive, other order of GAM); R = 30 m."""
    start = f"initial_ratio: {ratio}"

    def run(path: str, words: str, *more: str) -> RunSpec:
        return RunSpec(f"ch3_{path}", (alone(path, 30.0), law(words), *more, *COARSE), PRINTED_S)

    return (
        run("circle", f"{start}, {FIXED}"),
        run("circle", start),
        run("spiral", f"{start}, {FIXED}"),
        run("spiral", start),
        run("spiral", start, GROUPED),
    )


CORRECTED_PATHS = {
    "circle R = 30 m, 0.01 rad/s": ("circle", 30.0, 0.01, "fixed"),
    "spiral R = 30 m, 0.01 rad/s": ("spiral", 30.0, 0.01, "fixed"),
    "circle R = 10 m, 0.05 rad/s": ("circle", 10.0, 0.05, "fixed"),
    "circle R = 30 m, 0.05 rad/s": ("circle", 30.0, 0.05, "fixed"),
    "circle R = 30 m, 0.05 rad/s, heading along it": ("circle", 30.0, 0.05, "tangent"),
}


def corrected_runs(path: str, radius_m: float, rate_radps: float, heading: str) -> tuple[RunSpec, ...]:
    """Return PD, 0.7 fixed and adaptive, 1.3 fixed and adaptive, and adaptive from zero; without the box."""
    vehicle = alone(path, radius_m, rate_radps, model=BODY, heading=heading)

    def run(ratio: float, words: str = "box: false") -> RunSpec:
        changes = (vehicle, law(f"initial_ratio: {ratio}, {words}"), *CORRECTED_STEP)
        return RunSpec(f"ch3_{path}_corrected", changes, CORRECTED_S)

    still = f"box: false, {FIXED}"
    return (run(0.0, still), run(0.7, still), run(0.7), run(1.3, still), run(1.3), run(0.0))


OFF_BY = (0.7, 1.3)
CIRCLE_OFF = tuple(RunSpec("ch3_circle", (law(f"initial_ratio: {ratio}"), *COARSE)) for ratio in OFF_BY)
"""The formation with initial estimates that are wrong by 30 %."""

DRIFT_S = 600.0
DRIFT_SEEDS = tuple(range(321, 324))
DRIFT = {
    "adaptive, no box": "box: false",
    "adaptive, box": "box: true",
    "adaptive, leakage 1e-4 1/s, no box": "box: false, leakage_ps: 1.0e-4",
    "fixed estimates": f"box: false, {FIXED}",
}
DRIFT_RUNS = {
    name: tuple(
        RunSpec(
            "ch3_circle_corrected",
            (
                "sampling=sampled",
                "dt_s=0.05",
                f"seed={seed}",
                "environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.05}}",
                alone(model=BODY),
                law(f"initial_ratio: 0.7, {words}"),
            ),
            DRIFT_S,
        )
        for seed in DRIFT_SEEDS
    )
    for name, words in DRIFT.items()
}
"""The corrected law with noisy measurements, sampled at 0.05 s, R = 10 m, 0.01 rad/s, three draws."""


def late_rms_m(run: Run, after_s: float) -> float:
    """Return the rms of the first vehicle's |path - position| after `after_s` (m)."""
    late = errors(run.recording, run.scenario)[run.recording.t_s >= after_s][:, :3]
    return math.sqrt(float(np.mean((late**2).sum(axis=1))))


def late_errors_m(run: Run, after_s: float) -> list[float]:
    """Return the largest |error| of the first vehicle after `after_s`: x, y, z (m), yaw (rad)."""
    late = np.abs(errors(run.recording, run.scenario)[run.recording.t_s >= after_s])
    return [float(x) for x in late.max(axis=0)]


def estimate(run: Run, name: str, t_s: float, vehicle: int = 0) -> float:
    """Return a parameter estimate of the law, by name, at an instant (kg, N s/m, ...)."""
    tick = min(round(t_s / run.scenario.period_s), run.recording.n_ticks - 1)
    names = run.scenario.agent.controller.params.names
    return float(run.recording.law_state[tick, vehicle, names.index(name)])
