"""
Consensus filters of the flocking centre on a lossy modem: the thesis's filter, PI, push-sum, and no filter.

The thesis (Eq. (5.11)) assumes a constant undirected graph without delays. Here vehicles report in turn, in
slots. Reports arrive late or are lost, so the graph is directed and changes. Each number is the worst of
three seeds.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import legend_below, vehicle_style
from auv_flocking.codec import Field
from auv_flocking.reports.compact import Params, base_fields
from auv_thesis.acoustics.consensus_runs import (
    DURATION_S,
    FILTERS,
    FLYING,
    HELD,
    LAG,
    LONG,
    LONG_S,
    LOSSES,
    MEAN,
    MOVING,
    N_VEHICLES,
    PI,
    PUSH_SUM,
    STATIC,
    THESIS,
    VARIED,
    Numbers,
    errors_ned_m,
    numbers,
    payload,
    worst,
)
from auv_thesis.cases import by_case
from auv_thesis.items import (
    AGREES,
    DIFFERS,
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

_SMALL_M = 0.02
_ROUNDED_M = 0.5 * math.hypot(
    *(
        field.resolution
        for field in base_fields(Params())
        if isinstance(field, Field) and field.name.startswith("centre_minus_position_")
    )
)
"""Largest error of a centre in a report: half a step along each axis."""
_BIAS_M = (N_VEHICLES - 1) * _ROUNDED_M
"""An estimate adds up the others' rounded centres; (L + I)^-1 leaves the mean of these sums as it is."""
_DISAGREEMENT_M = 2.0 * (N_VEHICLES - 1) / N_VEHICLES * _ROUNDED_M / (N_VEHICLES + 1)
"""Reports are broadcast, so the sums differ by own roundings alone; (L + I)^-1 divides them by n + 1."""
_LOST_M = 10.0
_ALL_STATIC = tuple(spec for specs in STATIC.values() for spec in specs)
_SHOWN = tuple(STATIC[name, loss][0] for loss in LOSSES for name in FILTERS)


def _words(found: Numbers) -> str:
    settled = "never" if found.settled_s is None else f"after {found.settled_s:.0f} s"
    rate = "no rate" if found.rate_ps is None else f"{found.rate_ps:.3f} 1/s"
    return (
        f"bias of the mean {_m(found.bias_m)}, disagreement {_m(found.disagreement_m)}, convergence {rate}, "
        f"error under 5 % {settled}"
    )


def _m(length_m: float) -> str:
    if length_m >= 1e4:
        return f"{length_m:.0e} m"
    return f"{length_m:.1f} m" if length_m >= 10.0 else f"{length_m:.4f} m"


def thesis_disagreement_m(run: Run) -> float:
    """
    Return the steady-state distance of the thesis's estimates from their mean: the largest |eta_i - mean| /
    (n + 1) (m).

    This closed form holds for vehicles at rest that all hear each other.
    """
    positions = run.recording.position_ned_m[-1]
    away_m = np.linalg.norm(positions - positions.mean(axis=0), axis=-1).max()
    return float(away_m) / (N_VEHICLES + 1)


def _static_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (name, loss), group in by_case(STATIC, runs).items():
        found, (size, rate) = worst(group), payload(group[0])
        expected, verdict = "not given", NO_NUMBER
        if name in (THESIS, HELD):
            wanted_m = thesis_disagreement_m(group[0])
            is_near = abs(found.disagreement_m - wanted_m) < _DISAGREEMENT_M and found.bias_m < _BIAS_M
            expected, verdict = f"bias 0, disagreement {_m(wanted_m)}", AGREES if is_near else DIFFERS
        ours = f"{_words(found)}; {size} B, {rate:.0f} B/s"
        rows.append(Row(f"{name}, {100 * loss:.0f} % lost", expected, ours, verdict))
    return rows


def _varied_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (name, variant), run in zip(VARIED, runs, strict=True):
        size, rate = payload(run)
        ours = f"{_words(numbers(run))}; {size} B, {rate:.0f} B/s"
        rows.append(Row(f"{variant}: {name}", "not given", ours, NO_NUMBER))
    return rows


def _moving_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (name, follows), run in zip(MOVING, runs, strict=True):
        ours = f"error rms {_m(numbers(run).error_rms_m)}"
        words = "with" if follows else "without"
        rows.append(Row(f"{name}, {words} the flock's velocity", "not given", ours, NO_NUMBER))
    return rows


def _lag_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for words, run in zip(LAG, runs, strict=True):
        ours = f"mean of the vehicles {run.metrics['centroid_path_rms_m']:.2f} m from the path (rms)"
        rows.append(Row(words, "not given", ours, NO_NUMBER))
    return rows


def _flying_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for name, run in zip(FLYING, runs, strict=True):
        m = run.metrics
        path_m = m["centroid_path_formed_rms_m"]
        path = (
            "none, since the flock never formed" if path_m is None else f"{path_m:.2f} m (rms, once formed)"
        )
        ours = (
            f"smallest distance {m['pair_distance_min_m']:.2f} m, path {path}, worst estimate of the centre "
            f"{_m(m['consensus_error_max_m'])} (t > 100 s)"
        )
        rows.append(Row(name, "not given", ours, NO_NUMBER, "collision" if m["collision"] else ""))
    return rows


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    canvas.set_size_inches(6.5, 5.0)
    panels = canvas.subplots(2, 2, sharex=True, sharey=True)
    for panel, loss in enumerate(LOSSES):
        axes = panels.flat[panel]
        for index, name in enumerate(FILTERS):
            run = runs[panel * len(FILTERS) + index]
            size_m = np.linalg.norm(errors_ned_m(run), axis=-1).max(axis=1)
            axes.plot(run.recording.t_s[:-1], size_m, label=name, **vehicle_style(index))
        axes.set_yscale("log")
        axes.set_ylim(1e-4, 1e3)
        axes.set_xlim(0.0, DURATION_S)
        axes.set_title(f"{100 * loss:.0f} % lost")
    for axes in panels[1]:
        axes.set_xlabel("t (s)")
    for axes in panels[:, 0]:
        axes.set_ylabel("largest error of an estimate (m)")
    legend_below(canvas, panels.flat[0].get_legend_handles_labels()[0])


def _by_loss(runs: list[Run]) -> dict[float, Numbers]:
    """Return the worst numbers of one filter at every loss, from its runs in the order of `STATIC`."""
    return {loss: worst(drawn) for loss, drawn in by_case(LOSSES, runs).items()}


def _of(name: str) -> tuple[RunSpec, ...]:
    return tuple(spec for loss in LOSSES for spec in STATIC[name, loss])


def _largest(found: dict[float, Numbers]) -> str:
    return ", ".join(f"{_m(item.error_rms_m)} at {100 * loss:.0f} %" for loss, item in found.items())


def _judge_thesis(runs: list[Run]) -> Verdict:
    count = len(runs) // 2
    carried, held = _by_loss(runs[:count]), _by_loss(runs[count:])
    evidence = (
        f"rms error of the last minute: {_largest(carried)} of packets lost; without extrapolation by the "
        f"rate, {_largest(held)}"
    )
    if max(item.error_rms_m for item in carried.values()) < _LOST_M:
        return Verdict(HOLDS, evidence)
    bounded = max(item.error_rms_m for item in held.values()) < _LOST_M
    return Verdict(HOLDS_IN_PART if bounded else DOES_NOT_HOLD, evidence)


def _judge_exact(runs: list[Run]) -> Verdict:
    found, late_m = _by_loss(runs[:-1]), numbers(runs[-1]).error_rms_m
    small = [item.error_rms_m < _SMALL_M for item in found.values()]
    evidence = (
        f"rms error of the last minute of {DURATION_S:.0f} s: {_largest(found)} of packets lost; "
        f"at {100 * LOSSES[-1]:.0f} % after {LONG_S:.0f} s {_m(late_m)}"
    )
    if all(small[:-1]) and late_m < _SMALL_M:
        return Verdict(HOLDS, evidence)
    return Verdict(HOLDS_IN_PART if any(small) else DOES_NOT_HOLD, evidence)


def _judge_velocity(runs: list[Run]) -> Verdict:
    blind, informed, steered = (run.metrics["centroid_path_rms_m"] for run in runs)
    evidence = (
        f"{blind:.2f} m blind, {informed:.2f} m with it, {steered:.2f} m if the leader steers the centre"
    )
    return Verdict(HOLDS if informed < 0.6 * blind else DOES_NOT_HOLD, evidence)


FIGURES = (
    Figure(
        "A.21",
        "Estimates of the flocking centre against packet loss: four vehicles at rest",
        _SHOWN,
        _draw,
        "No counterpart in the thesis. Reports of 32 bytes and more in slots of 2 s, one seed. The "
        "thesis's filter keeps its bias at best. Estimates that are extrapolated with their rate over a "
        "cycle of 8 s feed back into each other.",
    ),
)

TABLES = (
    Table(
        "A.21",
        "Consensus filters against loss, vehicles at rest, slots of 2 s",
        _ALL_STATIC,
        _static_rows,
        "theory",
    ),
    Table("A.22", "The same at 60 % loss with one change each", tuple(VARIED.values()), _varied_rows),
    Table(
        "A.23", "The same at 30 % loss in a flock that moves at 0.1 m/s", tuple(MOVING.values()), _moving_rows
    ),
    Table(
        "A.24", "How much velocity consensus reduces the lag of a blind flock", tuple(LAG.values()), _lag_rows
    ),
    Table(
        "A.25",
        "Flocks that use each filter, slots of 2 s, 60 % loss",
        tuple(FLYING.values()),
        _flying_rows,
    ),
)

CLAIMS = (
    Claim(
        "A.21",
        "The thesis's filter keeps every estimate near the centre, also on a modem.",
        (*_of(THESIS), *_of(HELD)),
        _judge_thesis,
    ),
    Claim(
        "A.22",
        "Push-sum brings every estimate to the mean at any loss below 100 % (ours).",
        (*_of(PUSH_SUM), LONG[PUSH_SUM]),
        _judge_exact,
    ),
    Claim(
        "A.23",
        "The PI filter has no steady-state error for vehicles at rest (ours).",
        (*_of(PI), LONG[PI]),
        _judge_exact,
    ),
    Claim(
        "A.24",
        "If all vehicles hear each other, the mean of the neighbour estimates needs no consensus (ours).",
        (*_of(MEAN), LONG[MEAN]),
        _judge_exact,
    ),
    Claim(
        "A.25",
        "Velocity consensus nearly halves the lag of a flock whose followers do not know the path (ours).",
        tuple(LAG.values()),
        _judge_velocity,
    ),
)
