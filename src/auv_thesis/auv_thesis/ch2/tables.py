"""Chapter 2 in numbers: Table 2.2, and our own tables on open questions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from auv_experiment.metrics.path import SETTLING_WINDOW_S
from auv_thesis.ch2.claims_settling import POSITION_BANDS_M, VELOCITY_BANDS_MPS, time_words
from auv_thesis.ch2.runs import (
    APD,
    APD_60,
    APD_ABS,
    APD_ABS_OBSTACLES,
    APD_BODY,
    APD_BODY_OBSTACLES,
    APD_OBSTACLES,
    DAMPING_SCALES,
    MIXED,
    MIXED_NORTH,
    PD,
    PD_60,
    PD_ABS,
    PD_ABS_OBSTACLES,
    PD_BODY,
    PD_BODY_OBSTACLES,
    PD_OBSTACLES,
    SCALED,
    curves,
    settling_s,
)
from auv_thesis.items import AGREES, AGREES_IN_PART, DIFFERS, NO_NUMBER, Row, Run, Table


def _reading(quantity: str, thesis: str, value_m: float, note: str = "", table: str = "") -> Row:
    """
    Compare a cursor reading: agrees to every printed digit, in part within 10 %.

    `thesis` is the figure's reading; `table` is the table's value if it differs.
    """
    digits = len(thesis.partition(".")[2])
    rounded = f"{value_m:.{digits}f}"
    gap = abs(value_m - float(thesis))
    verdict = AGREES if rounded == thesis else AGREES_IN_PART if gap <= 0.1 * abs(float(thesis)) else DIFFERS
    printed = f"{table} m (Fig. 2.18: {thesis} m)" if table else f"{thesis} m"
    return Row(quantity, printed, f"{rounded} m", verdict, note)


def _time(quantity: str, thesis_s: float, found_s: Sequence[float | None], bands: str) -> Row:
    """
    Compare a settling time, for which the thesis gives no band, with ours for three bands.

    It agrees if all three are within 10 %, in part if any is within a factor of 3.
    """
    factors = [math.inf if s is None else max(s / thesis_s, thesis_s / s) for s in found_s]
    verdict = AGREES if max(factors) <= 1.1 else AGREES_IN_PART if min(factors) <= 3.0 else DIFFERS
    return Row(quantity, f"about {thesis_s:g} s", time_words(found_s), verdict, f"ours: bands of {bands}")


def _axis_time(law: str, axis: int, run: Run) -> Row:
    """Return the row of the time after which one position error is near zero."""
    c = curves(run)
    found_s = [settling_s(c.t_s, np.abs(c.pose_error[:, axis]), band) for band in POSITION_BANDS_M]
    return _time(f"{law}: {'xy'[axis]}_e near zero after", 10.0, found_s, _band_words(POSITION_BANDS_M, "m"))


def _velocity_time(quantity: str, thesis_s: float, run: Run, until_s: float = math.inf) -> Row:
    c = curves(run)
    found_s = [settling_s(c.t_s, c.largest_velocity_error_mps, band, until_s) for band in VELOCITY_BANDS_MPS]
    return _time(quantity, thesis_s, found_s, _band_words(VELOCITY_BANDS_MPS, "m/s"))


def _band_words(bands: Sequence[float], unit: str) -> str:
    return f"{' / '.join(f'{band:g}' for band in bands)} {unit}"


def _peak(quantity: str, low_mps: float, high_mps: float, found_mps: float, note: str) -> Row:
    verdict = AGREES if low_mps < found_mps < high_mps else DIFFERS
    return Row(quantity, f"{low_mps:g} to {high_mps:g} m/s", f"{found_mps:.3f} m/s", verdict, note)


def _rows_2_2(runs: list[Run]) -> list[Row]:
    pd, apd = (run.metrics for run in runs)
    starts_m = [float(curves(run).pose_error[0, 1]) for run in runs]
    sample = "one reading, not a steady value"
    axis = "from the axis limits"
    return [
        _reading("PD: x_e, first overshoot (at 5.4 s)", "0.3161", pd["x_err_5p4_m"], sample, "0.03161"),
        _reading("PD: y_e, first overshoot (at 0 s)", "10.00", starts_m[0], "the error at the start"),
        _reading("PD: x_e, steady (at 18.3 s)", "0.084", pd["x_err_18p3_m"], sample),
        _reading("PD: y_e, steady (at 32.9 s)", "-0.0202", pd["y_err_32p9_m"], sample),
        _reading("APD: x_e, first overshoot (at 5.8 s)", "0.2394", apd["x_err_5p8_m"], sample),
        _reading("APD: y_e, first overshoot (at 0 s)", "10.00", starts_m[1], "the error at the start"),
        _reading("APD: x_e, steady (at 18.6 s)", "-0.001288", apd["x_err_18p6_m"], sample, "-0.001281"),
        _reading("APD: y_e, steady (at 32.8 s)", "0.004325", apd["y_err_32p8_m"], sample),
        _axis_time("PD", 0, runs[0]),
        _axis_time("PD", 1, runs[0]),
        _velocity_time("PD: u_e, v_e near zero after", 22.0, runs[0]),
        _axis_time("APD", 0, runs[1]),
        _axis_time("APD", 1, runs[1]),
        _velocity_time("APD: u_e, v_e near zero after", 22.0, runs[1]),
        _peak("PD: peak of |v_e| (Fig. 2.8)", 2.0, 2.5, pd["velocity_err_y_peak_mps"], axis),
        _peak("APD: peak of |v_e| (Fig. 2.14)", 1.4, 1.6, apd["velocity_err_y_peak_mps"], axis),
    ]


_CASES = (
    ("as in the thesis", PD, APD),
    ("the same with drag |a| a", PD_ABS, APD_ABS),
    ("body frame, |a| a drag", PD_BODY, APD_BODY),
    ("body frame from 60 degrees", PD_60, APD_60),
)
_COMPARED = (
    ("largest x_e before 30 s (m)", "overshoot_x_m", ".4f"),
    ("smallest y_e before 30 s (m)", "undershoot_y_m", ".4f"),
    ("rms position error (m)", "position_rms_m", ".4f"),
    ("rms position error after 30 s (m)", "position_rms_after_30s_m", ".5f"),
    ("effort (N² s)", "control_effort_n2s", ".4e"),
)
_THESIS_OVERSHOOTS_M = (0.3161, 0.2394)


def _rows_against(runs: list[Run]) -> list[Row]:
    rows = []
    for number, (case, _, _) in enumerate(_CASES):
        plain, augmented = runs[2 * number].metrics, runs[2 * number + 1].metrics
        for label, key, digits in _COMPARED:
            first, second = plain[key], augmented[key]
            ours = f"{first:{digits}} → {second:{digits}}"
            change = f"{100.0 * (second / first - 1.0):+.1f} %"
            rows.append(Row(f"{case}: {label}", "", ours, NO_NUMBER, change))
    return [_with_thesis(rows[0], runs), *rows[1:]]


def _with_thesis(row: Row, runs: list[Run]) -> Row:
    """Compare the overshoots with the thesis's: in part if both decrease, but by another percentage."""
    before, after = _THESIS_OVERSHOOTS_M
    fall, ours = (1.0 - b / a for a, b in ((before, after), tuple(_overshoots_m(runs))))
    verdict = AGREES if abs(fall - ours) <= 0.02 else AGREES_IN_PART if fall * ours > 0.0 else DIFFERS
    return Row(row.quantity, f"{before} → {after} (-{100.0 * fall:.0f} %)", row.ours, verdict, row.note)


def _overshoots_m(runs: list[Run]) -> list[float]:
    return [run.metrics["overshoot_x_m"] for run in runs[:2]]


_PASSED = (
    ("as in the thesis", PD_OBSTACLES, APD_OBSTACLES),
    ("the same with drag |a| a", PD_ABS_OBSTACLES, APD_ABS_OBSTACLES),
    ("body frame, |a| a drag", PD_BODY_OBSTACLES, APD_BODY_OBSTACLES),
)


def _rows_obstacles(runs: list[Run]) -> list[Row]:
    rows = []
    for number, (case, _, _) in enumerate(_PASSED):
        for law, run in zip(("PD", "APD"), runs[2 * number : 2 * number + 2], strict=True):
            m, c, name = run.metrics, curves(run), f"{law}, {case}"
            near = ", ".join(
                f"{clearance:.3f} m at {at:.1f} s"
                for clearance, at in zip(m["obstacle_clearance_m"], m["obstacle_closest_at_s"], strict=True)
            )
            far = f"{m['position_err_max_m']:.3f} m, rms {m['position_rms_after_30s_m']:.4f} m"
            rows += [
                Row(
                    f"{name}: closest to obstacles 1 and 2",
                    "no collision",
                    near,
                    _is_clear(run),
                    "centre to centre",
                ),
                Row(f"{name}: largest error after 30 s", "", far, NO_NUMBER),
                _time(
                    f"{name}: position settles",
                    23.0,
                    [settling_s(c.t_s, c.distance_m, band, SETTLING_WINDOW_S) for band in POSITION_BANDS_M],
                    f"{_band_words(POSITION_BANDS_M, 'm')}, before {SETTLING_WINDOW_S:g} s",
                ),
                _velocity_time(f"{name}: velocity settles", 25.0, run, SETTLING_WINDOW_S),
            ]
    return rows


def _is_clear(run: Run) -> str:
    return AGREES if min(run.metrics["obstacle_clearance_m"]) > run.scenario.hull_radius_m else DIFFERS


def _rows_frames(runs: list[Run]) -> list[Row]:
    mixed, north, *scaled = runs
    late = "rms position error after 30 s"
    rows = [
        Row(f"frames mixed, start at 60 degrees: {late}", "", _late(mixed), NO_NUMBER, _settled(mixed)),
        Row(f"frames mixed, start north: {late}", "", _late(north), NO_NUMBER, _settled(north)),
    ]
    for scale, run in zip(DAMPING_SCALES, scaled, strict=True):
        quantity = f"APD, body frame, {scale:g} times the damping in the law: {late}"
        rows.append(Row(quantity, "", _late(run), NO_NUMBER))
    return rows


def _late(run: Run) -> str:
    return f"{run.metrics['position_rms_after_30s_m']:.4f} m"


def _settled(run: Run) -> str:
    found: Any = run.metrics["position_settling_0p1m_s"]
    return "never settles to 0.1 m" if found is None else f"settles to 0.1 m in {found:.1f} s"


TABLES = (
    Table("2.2", "Errors with PD and with augmented PD", (PD, APD), _rows_2_2),
    Table(
        "2.A",
        "PD → augmented PD with equal gains, in each frame and with each drag",
        tuple(spec for _, plain, augmented in _CASES for spec in (plain, augmented)),
        _rows_against,
    ),
    Table(
        "2.B",
        "Past the obstacles",
        tuple(spec for _, plain, augmented in _PASSED for spec in (plain, augmented)),
        _rows_obstacles,
    ),
    Table(
        "2.C",
        "Frames mixed as printed, and a law with wrong damping",
        (MIXED, MIXED_NORTH, *SCALED),
        _rows_frames,
    ),
)
