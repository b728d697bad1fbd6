"""Table 3.1, the axis limits of Figs 3.4-3.14 as a table, and our tables on the adaptive law."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from auv_thesis.ch3.runs import (
    CIRCLE,
    CIRCLE_CORRECTED,
    CORRECTED_LATE_S,
    CORRECTED_PATHS,
    PRINTED_LATE_S,
    RATIOS,
    READINGS,
    SPIRAL,
    SPIRAL_ALONE,
    corrected_runs,
    late_errors_m,
    late_rms_m,
    printed_runs,
)
from auv_thesis.items import AGREES, AGREES_IN_PART, DIFFERS, NO_NUMBER, Row, Run, Table

NOTHING = "-"
Bounds = tuple[float, float, float]
"""Lower limit, upper limit and tick of an axis."""


def fits(values: Sequence[float], bounds: Bounds) -> tuple[bool, bool]:
    """Return whether an automatically scaled axis would have these lower and upper limits."""
    bottom, top, tick = bounds
    return bottom <= min(values) < bottom + tick, top - tick < max(values) <= top


def _range_words(values: Sequence[float], unit: str) -> str:
    return f"{min(values):.5g} to {max(values):.5g} {unit}"


def _axis_row(name: str, unit: str, values: Sequence[float], bounds: Bounds, note: str = "") -> Row:
    bottom, top, tick = bounds
    met = fits(values, bounds)
    return Row(
        name,
        f"least in [{bottom:g}, {bottom + tick:g}), largest in ({top - tick:g}, {top:g}] {unit}",
        _range_words(values, unit),
        AGREES if all(met) else AGREES_IN_PART if any(met) else DIFFERS,
        note,
    )


# --- Table 3.1 -------------------------------------------------------------------------------------------

_PRINTED = {
    "inertia": ((99.0, 108.5, 126.5, 29.1), "m11, m22, m33 (kg), m44"),
    "linear_damping": ((10.0, 0.0, 10.0, 1.603), "constant term of d11, d22, d33, d44"),
    "quadratic_damping": ((227.18, 405.42, 227.18, 12.937), "speed-dependent term of d11, d22, d33, d44"),
}
_UNITS = {
    "inertia": "Printed in kg throughout; m44 is kg m^2.",
    "linear_damping": "Printed in kg/s throughout; d44 is kg m^2/s. Sway has none.",
    "quadratic_damping": "kg/m; d44 is kg m^2. (3.14)-(3.16) multiply by the speed once more; ours do not.",
}


def _parameters(runs: list[Run]) -> list[Row]:
    plant = runs[0].scenario.vehicles[0].model.params
    law = runs[0].scenario.agent.controller.params
    rows = [
        _numbers_row(words, printed, getattr(plant, key), _UNITS[key])
        for key, (printed, words) in _PRINTED.items()
    ]
    gains = (
        ("K_D", (10.0, 20.0, 50.0, 10.0), law.error_gain, ""),
        ("Λ", (50.0, 10.0, 20.0, 20.0), law.error_rate_ps, "1/s; the table gives no unit."),
        (
            "Γ in the order of (3.20)",
            (200.0, 10.0, 20.0, 0.0, 0.0, 0.0, 10.0, 10.0),
            [x for pair in zip(law.inertia_adaptation, law.quadratic_adaptation, strict=True) for x in pair],
            "(3.12) requires it to be positive definite. A zero freezes its parameter. Order: see Table 3.C.",
        ),
    )
    rows += [_numbers_row(words, printed, ours, note) for words, printed, ours, note in gains]
    body = runs[1].scenario.agent.controller.params
    corrected = (
        ("K_D of the corrected law", body.error_gain),
        ("Λ of the corrected law", body.error_rate_ps),
        (
            "Γ of the corrected law: m, d_L, d_Q",
            (*body.inertia_adaptation, *body.linear_adaptation, *body.quadratic_adaptation),
        ),
    )
    rows += [Row(words, NOTHING, _list(ours), NO_NUMBER) for words, ours in corrected]
    return rows


def _numbers_row(words: str, printed: Sequence[float], ours: Sequence[float], note: str) -> Row:
    verdict = AGREES if tuple(printed) == tuple(ours) else DIFFERS
    return Row(words, _list(printed), _list(ours), verdict, note)


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


# --- Table 3.A: the axes ---------------------------------------------------------------------------------


def _axes(runs: list[Run]) -> list[Row]:
    circle, spiral = runs
    z = circle.recording.position_ned_m[:, :, 2]
    rows = [_axis_row("3.4b depth", "m", [float(z.min()), float(z.max())], (0.0, 15.0, 5.0))]
    of_circle: tuple[tuple[str, str, str, Bounds], ...] = (
        ("3.5 position errors of AUV1", "m", "position_err_range_m", (-2.0, 10.0, 2.0)),
        ("3.6 velocity errors of AUV1", "m/s", "velocity_err_range_mps", (-7.0, 2.0, 1.0)),
        ("3.7 forces of AUV1", "N", "force_range_n", (-2000.0, 10000.0, 2000.0)),
        ("3.8a d12", "m", "d12_range_m", (-4.0, 12.0, 2.0)),
        ("3.8b d23", "m", "d23_range_m", (-2.0, 12.0, 2.0)),
        ("3.9 d12 - d23", "m", "d12_minus_d23_range_m", (-3.5, 1.5, 0.5)),
    )
    of_spiral: tuple[tuple[str, str, str, Bounds], ...] = (
        ("3.11 position errors of AUV1", "m", "position_err_range_m", (-2.0, 10.0, 2.0)),
        ("3.12 forces of AUV1", "N", "force_range_n", (-5000.0, 40000.0, 5000.0)),
        ("3.13a d12", "m", "d12_range_m", (0.0, 12.0, 2.0)),
        ("3.13b d23", "m", "d23_range_m", (0.0, 12.0, 2.0)),
        ("3.14 d12 - d23", "m", "d12_minus_d23_range_m", (-0.2, 1.2, 0.2)),
    )
    for run, quantities in ((circle, of_circle), (spiral, of_spiral)):
        rows += [_axis_row(name, unit, run.metrics[key], bounds) for name, unit, key, bounds in quantities]
    return rows


# --- Table 3.B: numbers of the runs as printed -----------------------------------------------------------


def _numbers(runs: list[Run]) -> list[Row]:
    circle, spiral, alone = runs
    m = circle.metrics
    settled = [m[f"{axis}_settling_0p05_s"] for axis in ("x", "y", "z", "yaw")]
    late = late_errors_m(circle, 100.0)
    true = [*m["d12_true_range_m"], *m["d23_true_range_m"]]
    depth = late_errors_m(alone, 40.0)[2]
    return [
        Row(
            "AUV1 settles to 0.05 m (rad): x, y, z, ψ",
            "by 100 s (Fig. 3.5)",
            ", ".join(f"{t_s:.2f}" for t_s in settled) + " s",
            AGREES if max(settled) < 100.0 else DIFFERS,
        ),
        Row(
            "overshoot y, z, ψ",
            "< 2",
            _overshoots(m),
            AGREES_IN_PART,
            "The thesis shows an upper bound only.",
        ),
        Row(
            "largest position error of AUV1 after 100 s",
            "0",
            f"{1e3 * max(late[:3]):.2f} mm",
            AGREES_IN_PART,
            "Zero at the resolution of the thesis's axis.",
        ),
        Row(
            "largest X, Y after 100 s",
            "0 (text under Fig. 3.7)",
            f"{m['x_force_late_n']:.2f}, {m['y_force_late_n']:.2f} N",
            DIFFERS,
            "Centripetal force and drag.",
        ),
        Row("d12, d23 stay within 0.05 m of 10 m after", "no time", _times(m), NO_NUMBER),
        Row(
            "|d - 10 m| after 100 s, at most",
            "0",
            _gap_mm(m),
            AGREES_IN_PART,
            "Zero at the resolution of the thesis's axis.",
        ),
        Row("|d12 - d23| at 300 s", "0", f"{1e3 * abs(m['d12_minus_d23_final_m']):.2f} mm", AGREES_IN_PART),
        Row("smallest distance between hulls", NOTHING, f"{min(true):.2f} m", NO_NUMBER),
        Row(
            "|d12 - d23| at 2000 s, spiral",
            "0",
            f"{1e3 * abs(spiral.metrics['d12_minus_d23_final_m']):.2f} mm",
            AGREES_IN_PART,
        ),
        Row(
            "steady error and force in depth, spiral",
            "0 (text to Fig. 3.11)",
            f"{1e3 * depth:.2f} mm, {abs(float(alone.recording.command[-1, 0, 2])):.2f} N",
            AGREES_IN_PART,
            "The error is d_L w / (K_D Λ): linear drag is not among the eight parameters.",
        ),
    ]


def _overshoots(m: dict[str, Any]) -> str:
    return f"{m['y_overshoot_m']:.3f} m, {m['z_overshoot_m']:.3f} m, {m['yaw_overshoot_rad']:.3f} rad"


def _times(m: dict[str, Any]) -> str:
    return f"{m['d12_settling_0p05_s']:.2f}, {m['d23_settling_0p05_s']:.2f} s"


def _gap_mm(m: dict[str, Any]) -> str:
    return f"{1e3 * m['d12_err_late_m']:.2f}, {1e3 * m['d23_err_late_m']:.2f} mm"


# --- Table 3.C: which interpretation fits ----------------------------------------------------------------

_AUV1_AXES: tuple[tuple[str, Bounds], ...] = (
    ("position_err_range_m", (-2.0, 10.0, 2.0)),
    ("velocity_err_range_mps", (-7.0, 2.0, 1.0)),
    ("force_range_n", (-2000.0, 10000.0, 2000.0)),
)


def _readings(runs: list[Run]) -> list[Row]:
    rows = []
    for name, run in zip(READINGS, runs, strict=True):
        hits = sum(sum(fits(run.metrics[key], bounds)) for key, bounds in _AUV1_AXES)
        x_s = run.metrics["x_settling_0p05_s"]
        late = late_errors_m(run, 150.0)[0]
        arrives = f"x within 0.05 m after {x_s:.1f} s" if x_s is not None else f"x still {late:.2f} m off"
        speed = abs(run.metrics["velocity_err_range_mps"][0])
        rows.append(
            Row(
                name,
                "6 limits of Figs 3.5-3.7, arrives",
                f"{hits} of 6; peak {speed:.2f} m/s; {arrives}",
                AGREES if hits == 6 and x_s is not None else AGREES_IN_PART if x_s is not None else DIFFERS,
            )
        )
    return rows


# --- Tables 3.D and 3.E: does adaptation help -------------------------------------------------------------


def _printed_adaptation(runs: list[Run]) -> list[Row]:
    rows = []
    for number, ratio in enumerate(RATIOS):
        group = [1e3 * late_rms_m(run, PRINTED_LATE_S) for run in runs[5 * number : 5 * number + 5]]
        name = "zero (fixed: plain PD)" if ratio == 0.0 else f"{ratio:g} of the true values"
        rows.append(
            Row(
                f"initial estimates {name}",
                NOTHING,
                f"circle {group[0]:.1f} -> {group[1]:.1f} mm; spiral {group[2]:.1f} -> {group[3]:.1f} mm; "
                f"spiral, other order {group[4]:.1f} mm",
                NO_NUMBER,
                f"adaptation removes {100 * (1 - group[1] / group[0]):.1f} and "
                f"{100 * (1 - group[3] / group[2]):.1f} %",
            )
        )
    return rows


def _corrected_adaptation(runs: list[Run]) -> list[Row]:
    rows = []
    for number, name in enumerate(CORRECTED_PATHS):
        pd, low, low_a, high, high_a, zero = (
            1e3 * late_rms_m(run, CORRECTED_LATE_S) for run in runs[6 * number : 6 * number + 6]
        )
        rows.append(
            Row(
                name,
                NOTHING,
                f"0.7: {low:.1f} -> {low_a:.1f} mm; 1.3: {high:.1f} -> {high_a:.1f} mm; "
                f"PD {pd:.1f} -> from zero {zero:.1f} mm",
                NO_NUMBER,
                f"smaller by {low / low_a:.0f}, {high / high_a:.0f} and {pd / zero:.0f} times",
            )
        )
    return rows


TABLES = (
    Table("3.1", "Parameters of the vehicle and of the law", (CIRCLE, CIRCLE_CORRECTED), _parameters),
    Table("3.A", "What the axes of Figs 3.4-3.14 reveal about their data", (CIRCLE, SPIRAL), _axes),
    Table("3.B", "Numbers of the law as printed", (CIRCLE, SPIRAL, SPIRAL_ALONE), _numbers),
    Table(
        "3.C",
        "Which interpretation of the printed law fits Figs 3.5-3.7",
        tuple(READINGS.values()),
        _readings,
    ),
    Table(
        "3.D",
        "Adaptation as printed, R = 30 m: rms error without -> with it",
        tuple(spec for ratio in RATIOS for spec in printed_runs(ratio)),
        _printed_adaptation,
    ),
    Table(
        "3.E",
        "Adaptation as corrected: rms error without -> with it",
        tuple(spec for path in CORRECTED_PATHS.values() for spec in corrected_runs(*path)),
        _corrected_adaptation,
    ),
)
