"""
Neighbour estimates: the extended Kalman filter compared with simpler estimators, and with sonar.

The thesis (Eqs. (5.29)-(5.35)) has a filter for every neighbour and gives no numbers for it. Here the filter
runs in the flock. Packets are late, rare or lost, and navigations drift.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.confidence.binomial import share_words
from auv_experiment.figures.plotting import legend_below, vehicle_style
from auv_flocking.neighbours.table import NeighbourConfig
from auv_thesis.acoustics.estimation_runs import (
    BAR,
    DRIFTING,
    DURATION_S,
    FORMED_S,
    GRID,
    LOSSES,
    SLOTS_S,
    errors_of,
    relative_errors,
    rms_m,
)
from auv_thesis.cases import by_case
from auv_thesis.intervals import mean_words
from auv_thesis.items import (
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    Table,
    Verdict,
)

_SETTLE_S = 20.0
_MODELS = {
    "constant velocity, density fixed at 1e-3": NeighbourConfig(timeout_s=300.0),
    "constant velocity, density fixed at 1e-4": NeighbourConfig(acceleration_psd=1e-4, timeout_s=300.0),
    "constant velocity, density follows over 60 s": NeighbourConfig(
        acceleration_memory_s=60.0, timeout_s=300.0
    ),
    "the same, noise of 2 cm and 3 cm/s instead of the rounding's": NeighbourConfig(
        acceleration_memory_s=60.0, position_std_m=0.02, velocity_std_mps=0.03, timeout_s=300.0
    ),
    "density follows over 60 s, velocity returns to the flock's in 15 s (as flown)": None,
}
_TUNED_ON = {"0.5 s slots": GRID[0.5, 0.3], "2 s slots": GRID[2.0, 0.3]}
_SHOWN = ("drift", "drift, fixes every 60 s", "drift, sonar", "exact navigation")


class _Three(NamedTuple):
    """Root mean square errors of the filter, of the last packet held and of dead reckoning (m)."""

    ekf_m: float
    hold_m: float
    reckoned_m: float


def _three(run: Run) -> _Three:
    errors = errors_of(run).between(_SETTLE_S, DURATION_S)
    return _Three(rms_m(errors.ekf_m), rms_m(errors.hold_m), rms_m(errors.reckoned_m))


def _grid(runs: list[Run]) -> dict[tuple[float, float], list[_Three]]:
    return by_case(GRID, [_three(run) for run in runs])


def _words(values: Sequence[float], unit: str, digits: int = 3) -> str:
    """Return the mean over flights with its interval; a single flight has none."""
    return mean_words(values, unit, digits) if len(values) > 1 else f"{values[0]:.{digits}f} {unit}".rstrip()


def _grid_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (slot_s, loss), found in _grid(runs).items():
        ekf_m, hold_m, reckoned_m = zip(*found, strict=True)
        ratios = [one.ekf_m / one.hold_m for one in found]
        rows.append(
            Row(
                f"slots of {slot_s:g} s, {100.0 * loss:.0f} % lost",
                "not given",
                f"filter {_words(ekf_m, 'm')}, last packet held {_words(hold_m, 'm')}, dead reckoned "
                f"{_words(reckoned_m, 'm')}; filter / held {_words(ratios, '', 2)}",
                NO_NUMBER,
                f"n = {len(found)}",
            )
        )
    return rows


def _model_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for cell, flights in by_case(_TUNED_ON, runs).items():
        for name, config in _MODELS.items():
            flown = [errors_of(run, config) for run in flights]
            parts = []
            for phase, from_s, to_s in (("gathering", 0.0, FORMED_S), ("formed", FORMED_S, DURATION_S)):
                found = [errors.between(from_s, to_s) for errors in flown]
                parts.append(
                    f"{phase}: error {_words([rms_m(part.ekf_m) for part in found], 'm')}, "
                    f"stated {_words([part.said_m for part in found], 'm')}, "
                    f"NEES {_words([part.nees for part in found], '', 2)}"
                )
            rows.append(
                Row(
                    f"{cell}, 30 % lost: {name}",
                    "3 (NEES of three numbers)",
                    "; ".join(parts),
                    NO_NUMBER,
                    f"n = {len(flights)}",
                )
            )
    return rows


def _drift_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for name, run in zip(DRIFTING, runs, strict=True):
        errors_m, covariance = relative_errors(run).formed()
        lengths_m = np.sqrt(np.square(errors_m).sum(axis=1))
        solved = np.linalg.solve(covariance, errors_m[..., None])[..., 0]
        said_m = float(np.sqrt(np.trace(covariance, axis1=1, axis2=2).mean()))
        rows.append(
            Row(
                name,
                "not given",
                f"rms {rms_m(errors_m):.3f} m, 95 % under {np.quantile(lengths_m, 0.95):.3f} m, "
                f"stated {said_m:.3f} m, NEES of position {(errors_m * solved).sum(axis=1).mean():.2f}",
                NO_NUMBER,
            )
        )
    return rows


def _draw_grid(canvas: Canvas, runs: list[Run]) -> None:
    found = _grid(runs)
    panels = canvas.subplots(1, len(LOSSES), sharey=True)
    for axes, loss in zip(panels, LOSSES, strict=True):
        for index, name in enumerate(("filter", "last packet held", "dead reckoned")):
            values_m = [[one[index] for one in found[slot_s, loss]] for slot_s in SLOTS_S]
            style = vehicle_style(index)
            axes.plot(SLOTS_S, [np.mean(drawn) for drawn in values_m], marker="o", label=name, **style)
            least_m, most_m = [min(drawn) for drawn in values_m], [max(drawn) for drawn in values_m]
            axes.vlines(SLOTS_S, least_m, most_m, color=style["color"], linewidth=1.0)
        axes.set_title(f"{100.0 * loss:.0f} % lost")
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.set_xticks(SLOTS_S, [f"{slot_s:g}" for slot_s in SLOTS_S])
        axes.set_xlabel("slot (s)")
    panels[0].set_ylabel("rms error of a neighbour (m)")
    handles, labels = panels[0].get_legend_handles_labels()
    legend_below(canvas, handles, labels)


def _draw_drift(canvas: Canvas, runs: list[Run]) -> None:
    axes = canvas.subplots()
    for index, (name, run) in enumerate(zip(_SHOWN, runs, strict=True)):
        relative = relative_errors(run)
        axes.plot(relative.t_s, relative.rms_over_time_m(), label=name, **vehicle_style(index))
    axes.set_yscale("log")
    axes.set_xlim(0.0, DURATION_S)
    axes.set_xlabel("t (s)")
    axes.set_ylabel("rms error of relative positions (m)")
    handles, labels = axes.get_legend_handles_labels()
    legend_below(canvas, handles, labels)


def _judge_half(runs: list[Run]) -> Verdict:
    found = [_three(run) for run in runs]
    words = [
        f"filter {ekf_m:.3f} m, held {hold_m:.3f} m (ratio {ekf_m / hold_m:.2f}), "
        f"dead reckoned {reckoned_m:.3f} m"
        for ekf_m, hold_m, reckoned_m in found
    ]
    good = [ekf_m <= 0.5 * hold_m for ekf_m, hold_m, _ in found]
    verdict = HOLDS if all(good) else HOLDS_IN_PART if any(good) else DOES_NOT_HOLD
    return Verdict(verdict, "; ".join(words))


def _judge_reckoning(runs: list[Run]) -> Verdict:
    """Judge the means of the cells: a single flight may hear its packets at lucky times."""
    cells = [[one.ekf_m / one.reckoned_m for one in found] for found in _grid(runs).values()]
    means = [float(np.mean(ratios)) for ratios in cells]
    better, flights = sum(mean < 1.0 for mean in means), [ratio for ratios in cells for ratio in ratios]
    below = share_words(sum(ratio < 1.0 for ratio in flights), len(flights))
    evidence = (
        f"filter / dead reckoning, mean of a cell's flights (n = {len(cells[0])}), between {min(means):.2f} "
        f"and {max(means):.2f}, below 1 in {better} of {len(means)} cells; flights below 1: {below}"
    )
    verdict = HOLDS if better == len(means) else HOLDS_IN_PART if better else DOES_NOT_HOLD
    return Verdict(verdict, evidence)


def _judge_sonar(runs: list[Run]) -> Verdict:
    exact_m, drift_m, sonar_m = (rms_m(relative_errors(run).formed()[0]) for run in runs)
    evidence = (
        f"relative positions in the formed flock, rms: {drift_m:.3f} m with drift, {sonar_m:.3f} m "
        f"with drift and sonar, {exact_m:.3f} m with exact navigation and no sonar"
    )
    return Verdict(HOLDS if sonar_m < 0.2 < drift_m else DOES_NOT_HOLD, evidence)


_EVERY_FLIGHT = tuple(spec for flights in GRID.values() for spec in flights)

FIGURES = (
    Figure(
        "A.31",
        "Error of neighbour estimates against slot length and loss",
        _EVERY_FLIGHT,
        _draw_grid,
        "No counterpart in the thesis. Four hulls in the flock, one slot each; mean over flights, and lines "
        "from the smallest to the largest error of a flight. During silence, dead "
        "reckoning extrapolates the velocity that the neighbour had while gathering; the filter lets the "
        "velocity return to the flock's velocity.",
    ),
    Figure(
        "A.33",
        "Relative positions with navigations that drift",
        tuple(DRIFTING[name] for name in _SHOWN),
        _draw_drift,
        "No counterpart in the thesis. Estimates from packets alone contain the drift of both navigations. "
        "The sonar (2 Hz, contacts without names) removes it.",
    ),
)

TABLES = (
    Table("A.31", "Error of a neighbour's position in the flock", _EVERY_FLIGHT, _grid_rows),
    Table(
        "A.33",
        "Models of a neighbour's motion, on the same packets",
        tuple(spec for flights in _TUNED_ON.values() for spec in flights),
        _model_rows,
        "consistent",
    ),
    Table(
        "A.34",
        "Relative positions in the formed flock (0.5 s slots, 30 % lost)",
        tuple(DRIFTING.values()),
        _drift_rows,
    ),
)

CLAIMS = (
    Claim(
        "A.31",
        "With 2 s slots and 30 % loss the filter's error is at most half that of holding the last packet "
        "(ours).",
        BAR,
        _judge_half,
    ),
    Claim(
        "A.32",
        "The filter is better than dead reckoning from the last packet (ours).",
        _EVERY_FLIGHT,
        _judge_reckoning,
    ),
    Claim(
        "A.33",
        "If navigations drift by metres, sonar keeps relative positions within decimetres (ours).",
        (DRIFTING["exact navigation"], DRIFTING["drift"], DRIFTING["drift, sonar"]),
        _judge_sonar,
    ),
)
