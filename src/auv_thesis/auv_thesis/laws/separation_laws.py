"""
Every separation law in one flock: vehicles and modem of the main job, under disturbances.

The flocking law is `potential` with gains that suit the modem, so that only the separation law keeps
distances: the main job's own law would widen them with its uncertainty and bound the approach. Chapter 6
compares separation laws on single integrators that see each other. Here they, and the adaptive law of its
future work, fly on hulls of 125 kg with a modem and one report per second. There are no obstacles, so that
the distance error is the law's own.

Parameters: the mathematical law as in the main job; the fuzzy law with a set "zero" of 0.25 m, since the
0.045 m that give the thesis's distances are too stiff for a hull of 125 kg and one report per second (one row
shows it); the adaptive law with its defaults.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import vehicle_style
from auv_experiment.metrics.distances import pair_distances_m
from auv_thesis.ch4_6.flock_drawing import distance_panels, legend_of
from auv_thesis.items import (
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    RunSpec,
    Table,
    Verdict,
)

DURATION_S = 200.0
JUDGED_AFTER_S = 100.0
_N_VEHICLES = 4
_FREE = "environment.obstacles=[]"
_POTENTIAL = (
    "agent.hold_s=10.0",
    "agent.flocking={kind: potential, params: {path_gain_ps: 0.1, bandwidth_ratio: 0.2, followers: blind}}",
    "agent.flocking.params.leader_steers=centre",
    "agent.flocking.params.feedforward=flock",
    "agent.flocking.params.correction_limit_mps=0.2",
    "agent.consensus={kind: thesis, params: {rate_ps: 1.0, follow_flock: true}}",
)
_KIND, _PARAMS = "agent.separation.kind", "agent.separation.params"

LAWS = {
    "mathematical": (f"{_KIND}=mathematical",),
    "fuzzy": (f"{_KIND}=fuzzy", f"{_PARAMS}.input_peaks_m=[-5.0,-0.25,0.0,0.25,5.0]"),
    "adaptive fuzzy": (f"{_KIND}=adaptive_fuzzy",),
}
_THESIS_SETS = (f"{_KIND}=fuzzy",)


def _plant(factor: float) -> tuple[str, ...]:
    """Return the vehicles with inertia, added mass and drag scaled by a factor; gains stay the same."""
    numbers: dict[str, float | list[float]] = {
        "mass_kg": 125.0,
        "inertia_kgm2": [8.0, 8.0, 8.0],
        "added_mass": [62.5, 62.5, 62.5, 0.0, 0.0, 0.0],
        "quadratic_damping": [48.0, 48.0, 48.0, 80.0, 80.0, 80.0],
    }
    scaled = {
        name: round(factor * value, 6)
        if isinstance(value, float)
        else [round(factor * item, 6) for item in value]
        for name, value in numbers.items()
    }
    return tuple(
        f"vehicles.{index}.model.params.{name}={value}"
        for index in range(_N_VEHICLES)
        for name, value in scaled.items()
    )


def _limit(force_n: float) -> tuple[str, ...]:
    """Return thrusters with this force limit, which the controllers know."""
    wrench = [force_n] * 3 + [50.0] * 3
    hulls = tuple(f"vehicles.{index}.model.params.max_wrench={wrench}" for index in range(_N_VEHICLES))
    return (*hulls, f"agent.controller.params.max_force_n={force_n}")


CONDITIONS: dict[str, tuple[str, ...]] = {
    "nominal (0.05 m/s current, 150 N)": (),
    "plant + 30 %": _plant(1.3),
    "plant - 30 %": _plant(0.7),
    "current 0.1 m/s": ("environment.current_ned_mps=[0.08,0.06,0.0]",),
    "noise 5 cm, 1 cm/s": (
        "environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.01}}",
    ),
    "forces up to 200 N": _limit(200.0),
    "forces up to 20 N": _limit(20.0),
}


def _spec(law: tuple[str, ...], condition: tuple[str, ...]) -> RunSpec:
    return RunSpec("flock_acoustic", (_FREE, *_POTENTIAL, *law, *condition), DURATION_S)


RUNS = {
    (law, condition): _spec(overrides, changes)
    for condition, changes in CONDITIONS.items()
    for law, overrides in LAWS.items()
}
NARROW = _spec(_THESIS_SETS, ())
_NOMINAL = tuple(RUNS[law, next(iter(CONDITIONS))] for law in LAWS)


def distance_numbers(run: Run) -> dict[str, float]:
    """
    Return a summary of a flock's distances.

    Returns
    -------
    numbers : dict
        rms_m and worst_m of distance minus spacing over all pairs for t > 100 s, effort_n (rms force of a
        vehicle for t > 100 s), smallest_m (of any pair at any time).

    """
    flocking: Any = run.scenario.agent.flocking
    t_s, distances_m = run.recording.t_s, pair_distances_m(run.recording)
    error_m = distances_m[t_s > JUDGED_AFTER_S] - flocking.params.spacing_m
    force_n = run.recording.command[t_s[:-1] > JUDGED_AFTER_S][..., :3]
    return {
        "rms_m": float(np.sqrt(np.square(error_m).mean())),
        "worst_m": float(np.abs(error_m).max()),
        "effort_n": float(np.sqrt(np.square(force_n).sum(axis=-1).mean())),
        "smallest_m": float(distances_m.min()),
    }


def _row(quantity: str, run: Run) -> Row:
    numbers = distance_numbers(run)
    ours = (
        f"rms {numbers['rms_m']:.3f} m, worst {numbers['worst_m']:.3f} m, force {numbers['effort_n']:.1f} N, "
        f"smallest {numbers['smallest_m']:.2f} m"
    )
    note = "collision" if run.metrics["collision"] else ""
    return Row(quantity, "not given", ours, NO_NUMBER, note)


def _rows(runs: list[Run]) -> list[Row]:
    rows = [_row(f"{condition}: {law}", run) for (law, condition), run in zip(RUNS, runs, strict=False)]
    return [*rows, _row("nominal: fuzzy with the sets that give the thesis's distances", runs[-1])]


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    (axes,) = distance_panels(canvas, 1)
    for index, (law, run) in enumerate(zip(LAWS, runs, strict=True)):
        mean_m = pair_distances_m(run.recording).mean(axis=1)
        axes.plot(run.recording.t_s, mean_m, label=law, **vehicle_style(index))
    axes.axhline(2.0, color="0.5", linewidth=0.8)
    axes.set_xlim(0.0, DURATION_S)
    axes.set_ylim(0.0, 8.0)
    axes.set_xlabel("t (s)")
    axes.set_ylabel("mean distance of pairs (m)")
    legend_of(canvas, axes)


def _judge_adaptive(runs: list[Run]) -> Verdict:
    values = dict(zip(RUNS, (distance_numbers(run)["rms_m"] for run in runs), strict=True))
    wins = [
        values["adaptive fuzzy", condition]
        < min(values["fuzzy", condition], values["mathematical", condition])
        for condition in CONDITIONS
    ]
    of_law = {law: [values[law, condition] for condition in CONDITIONS] for law in LAWS}
    words = ", ".join(f"{law} {min(rms):.3f} to {max(rms):.3f} m" for law, rms in of_law.items())
    evidence = f"rms distance error over the {len(wins)} conditions: {words}; least in {sum(wins)} of them"
    return Verdict(HOLDS if all(wins) else HOLDS_IN_PART if any(wins) else DOES_NOT_HOLD, evidence)


def _judge_fuzzy(runs: list[Run]) -> Verdict:
    mathematical, tuned, _, narrow = (distance_numbers(run) for run in runs)
    evidence = (
        f"rms distance error {mathematical['rms_m']:.3f} m mathematical; fuzzy {tuned['rms_m']:.3f} m with "
        f"{tuned['effort_n']:.1f} N; with the sets that give the thesis's distances {narrow['rms_m']:.3f} m "
        f"with {narrow['effort_n']:.1f} N, chattering by up to {narrow['worst_m']:.2f} m"
    )
    better = tuned["rms_m"] < mathematical["rms_m"]
    carries_over = narrow["effort_n"] < 2.0 * mathematical["effort_n"]
    return Verdict(HOLDS if better and carries_over else HOLDS_IN_PART if better else DOES_NOT_HOLD, evidence)


FIGURES = (
    Figure(
        "6.A",
        "Mean distance of pairs in the main job's flock, three separation laws",
        _NOMINAL,
        _draw,
        "No counterpart in the thesis. The adaptive law brings the distance to d = 2 m; with the others it "
        "settles where repulsion and attraction balance.",
    ),
)

TABLES = (
    Table(
        "6.B", "Separation laws in the main job's flock under disturbances", (*RUNS.values(), NARROW), _rows
    ),
)

CLAIMS = (
    Claim(
        "6.7",
        "The fuzzy law keeps distances nearer to d with hulls and a modem, too.",
        (*_NOMINAL, NARROW),
        _judge_fuzzy,
    ),
    Claim(
        "7.3",
        "An adaptive fuzzy law keeps them nearer still (future work of the thesis; the law is ours).",
        tuple(RUNS.values()),
        _judge_adaptive,
    ),
)
