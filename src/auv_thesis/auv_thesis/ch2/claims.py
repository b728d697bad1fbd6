"""The claims of chapter 2, judged from runs."""

from __future__ import annotations

import math

import numpy as np

from auv_experiment.confidence.binomial import share_words
from auv_thesis.ch2.runs import (
    APD,
    APD_60,
    APD_BODY,
    APD_BODY_OBSTACLES,
    APD_OBSTACLES,
    BESIDE,
    DAMPING_SCALES,
    FROM_STARTS,
    GAIN_RUNS,
    GAIN_SETS,
    HEADINGS_DEG,
    MIXED_FROM,
    OFFSETS_M,
    PD,
    PD_60,
    PD_BODY,
    PD_BODY_OBSTACLES,
    PD_OBSTACLES,
    PRINTED_DRAG_FAR,
    REAL_DRAG_FAR,
    SCALED,
    STARTS,
    Curves,
    curves,
)
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Claim, Run, Verdict

LATE_S = 100.0
PD_READINGS = (("x_err_5p4_m", "0.3161"), ("x_err_18p3_m", "0.084"), ("y_err_32p9_m", "-0.0202"))
PRINTED_GAINS = (40.0, 50.0)


def _clear_obstacles(runs: list[Run]) -> Verdict:
    with_law, without, beside = runs[:4], runs[4], runs[5:]
    radius_m = without.scenario.hull_radius_m
    nearest_m = min(min(run.metrics["obstacle_clearance_m"]) for run in with_law)
    beside_m = min(min(run.metrics["obstacle_clearance_m"]) for run in beside)
    obstacles = with_law[0].scenario.environment.obstacles
    track = without.recording.position_ned_m[:, 0]
    otherwise_m = [float(np.linalg.norm(track - np.array(o.position_ned_m), axis=1).min()) for o in obstacles]
    evidence = (
        f"closest of {len(with_law)} runs: {nearest_m:.3f} m from an obstacle's centre, with a hull of "
        f"{radius_m:g} m; "
        "without obstacles the same track passes these points at "
        + " and ".join(f"{distance_m:.3f} m" for distance_m in otherwise_m)
        + f". Both laws past an obstacle from {OFFSETS_M[0]:g} to {OFFSETS_M[-1]:+g} m beside the path, "
        f"{len(beside)} runs: closest {beside_m:.3f} m, with the obstacle on the path. The obstacles are "
        f"points; a radius above {nearest_m - radius_m:.2f} m, and {beside_m - radius_m:.2f} m on the path, "
        "would have been hit"
    )
    return Verdict(HOLDS if min(nearest_m, beside_m) > radius_m else DOES_NOT_HOLD, evidence)


def _compare_laws(runs: list[Run]) -> Verdict:
    better, words = [], []
    pairs, drawn = runs[:4], runs[4 : 4 + 2 * STARTS]
    for plain, augmented in zip(pairs[::2], pairs[1::2], strict=True):
        a, b = plain.metrics, augmented.metrics
        keys = ("overshoot_x_m", "position_rms_m", "position_rms_after_30s_m")
        better += [b[key] < a[key] for key in keys]
        words.append(
            f"{plain.scenario.name}: overshoot in x {a[keys[0]]:.3f} → {b[keys[0]]:.3f} m "
            f"({_change(a[keys[0]], b[keys[0]])}), rms {a[keys[1]]:.4f} → {b[keys[1]]:.4f} m "
            f"({_change(a[keys[1]], b[keys[1]])}), rms after 30 s {a[keys[2]]:.5f} → {b[keys[2]]:.5f} m"
        )
    late_m = [run.metrics["position_rms_after_30s_m"] for run in drawn]
    wins = sum(b < a for a, b in zip(late_m[:STARTS], late_m[STARTS:], strict=True))
    scaled_m = [run.metrics["position_rms_after_30s_m"] for run in runs[4 + 2 * STARTS :]]
    better += [wins == STARTS, max(scaled_m) < pairs[2].metrics["position_rms_after_30s_m"]]
    evidence = (
        f"equal gains. {'; '.join(words)}. From drawn starts and headings the rms after 30 s is smaller in "
        f"{share_words(wins, STARTS)}. With {DAMPING_SCALES[0]:g} to {DAMPING_SCALES[-1]:g} times the "
        f"damping in the law it is at most {max(scaled_m):.4f} m. The rms of the whole run changes little: "
        "the initial error of 10 m dominates"
    )
    return Verdict(HOLDS if all(better) else DOES_NOT_HOLD, evidence)


def _falls(runs: list[Run]) -> Verdict:
    words, falling = [], []
    for run in runs:
        for name in ("thesis", "corrected"):
            falling.append(run.metrics[f"lyapunov_{name}_falls"])
            words.append(f"{run.scenario.name}, {name} V: {_course(run, name)}")
    gaps = {str(run.metrics["lyapunov_proof_gap"]) for run in runs if "lyapunov_proof_gap" in run.metrics}
    evidence = "; ".join(words) + "".join(f". Why: {gap}" for gap in sorted(gaps))
    return Verdict(HOLDS if all(falling) else HOLDS_IN_PART if any(falling) else DOES_NOT_HOLD, evidence)


def _course(run: Run, name: str) -> str:
    """Return as text whether a Lyapunov candidate decreases along a run."""
    m, prefix = run.metrics, f"lyapunov_{name}"
    if m[f"{prefix}_falls"]:
        return "falls throughout"
    share = 100.0 * m[f"{prefix}_rise_ratio"]
    return f"rises, first at {m[f'{prefix}_first_rise_s']:.1f} s, in {share:.0f} % of the records"


def _steer(runs: list[Run]) -> Verdict:
    late_rad = [_late_heading_rad(curves(run)) for run in runs]
    moments_nm = max(float(np.abs(run.recording.command[:, 0, 5]).max()) for run in runs)
    least_rad = min(low for low, _ in late_rad)
    evidence = (
        "heading error after 100 s: "
        + "; ".join(
            f"{run.scenario.name} {low:.2f} to {high:.2f} rad"
            for run, (low, high) in zip(runs, late_rad, strict=True)
        )
        + f"; largest commanded yaw moment: {moments_nm:g} N m"
    )
    return Verdict(HOLDS if least_rad < 0.05 and moments_nm > 0.0 else DOES_NOT_HOLD, evidence)


def _late_heading_rad(c: Curves) -> tuple[float, float]:
    late = np.abs(c.pose_error[c.t_s >= LATE_S, 2])
    return float(late.min()), float(late.max())


def _find_gains(runs: list[Run]) -> Verdict:
    """Judge the printed K_v = [40 50 0]: which of nine sets of gains gives the PD row of Table 2.2?"""
    matching = [gains for gains, run in zip(GAIN_SETS, runs, strict=True) if _gives_pd_row(run)]
    printed = runs[GAIN_SETS.index(PRINTED_GAINS)].metrics
    found = ", ".join(f"{printed[key]:.{len(text.partition('.')[2])}f}" for key, text in PD_READINGS)
    wanted = ", ".join(text for _, text in PD_READINGS)
    sets = ", ".join(f"[{k_u:g} {k_v:g} 0]" for k_u, k_v in matching) or "none"
    evidence = (
        f"the thesis reads {wanted} m; K_v = [40 50 0] gives {found} m. Of {len(runs)} sets with gains of "
        f"40, 50 and 60, those that give all three to every digit: {sets}. This is a fit to three readings; "
        "it assumes J = I, a start at the origin and the drag as printed"
    )
    return Verdict(HOLDS if matching == [PRINTED_GAINS] else DOES_NOT_HOLD, evidence)


def _gives_pd_row(run: Run) -> bool:
    return all(f"{run.metrics[key]:.{len(text.partition('.')[2])}f}" == text for key, text in PD_READINGS)


def _use_printed_frames(runs: list[Run]) -> Verdict:
    *mixed, plain, augmented = runs
    settled = [run.metrics["position_settling_0p1m_s"] is not None for run in mixed]
    late_m = [run.metrics["position_rms_after_30s_m"] for run in mixed]
    headings = ", ".join(f"{degrees}" for degrees in HEADINGS_DEG)
    rms = ", ".join(f"{error_m:.3f}" for error_m in late_m)
    evidence = (
        f"heading not controlled, initially {headings} degrees: PD with NED errors as body forces is "
        f"{rms} m off, rms after 30 s, and settles to 0.1 m from {sum(settled)} of {len(settled)} headings. "
        f"From 60 degrees PD rotated into the body frame has {plain.metrics['position_rms_after_30s_m']:.3f} "
        f"m, augmented PD {augmented.metrics['position_rms_after_30s_m']:.4f} m"
    )
    return Verdict(HOLDS if all(settled) else DOES_NOT_HOLD, evidence)


def _brake(runs: list[Run]) -> Verdict:
    """Judge (2.10) as printed: drag must never do positive work."""
    printed, real = (_drag_power_w(run) for run in runs)
    speeds = [float(curves(run).velocity[:, 1].min()) for run in runs]
    evidence = (
        f"from y = {curves(runs[0]).pose[0, 1]:g} m, with the drag as printed the vehicle reaches "
        f"{speeds[0]:.2f} m/s across, and its drag drives it with up to {printed:.0f} W; with |v| v it "
        f"reaches {speeds[1]:.2f} m/s and the drag gives at most {real + 0.0:.0f} W. From a start a little "
        "farther out the printed equations have no finite solution (test_path_following.py)"
    )
    return Verdict(HOLDS if printed <= 0.0 else DOES_NOT_HOLD, evidence)


def _drag_power_w(run: Run) -> float:
    """Return the largest power that the sway drag adds to the vehicle (W)."""
    params = run.scenario.vehicles[0].model.params
    v = curves(run).velocity[:, 1]
    square = v * v if params.drag == "thesis" else np.abs(v) * v
    force_n = -(params.linear_damping[1] * v + params.quadratic_damping[1] * square)
    return float((force_n * v).max())


def _change(before: float, after: float) -> str:
    return f"{100.0 * (after / before - 1.0):+.1f} %" if math.isfinite(before) and before else "no ratio"


CLAIMS = (
    Claim(
        "2.6",
        "The vehicle passes the obstacles without a collision.",
        (PD_OBSTACLES, APD_OBSTACLES, PD_BODY_OBSTACLES, APD_BODY_OBSTACLES, PD, *BESIDE),
        _clear_obstacles,
    ),
    Claim(
        "2.6.3",
        "Augmented PD performs better than PD.",
        (PD, APD, PD_BODY, APD_BODY, *FROM_STARTS, *SCALED),
        _compare_laws,
    ),
    Claim(
        "2.5.1.3",
        "The closed loop with PD is Lyapunov stable: V of (2.28) decreases.",
        (PD, PD_BODY, PD_OBSTACLES),
        _falls,
    ),
    Claim(
        "2.5.2.3",
        "The closed loop with augmented PD is Lyapunov stable: V of (2.42) decreases, with obstacles too.",
        (APD, APD_BODY, APD_OBSTACLES, APD_BODY_OBSTACLES),
        _falls,
    ),
    Claim(
        "2.6.1",
        "The vehicle matches the path in position and in orientation.",
        (PD, APD, PD_BODY, APD_BODY),
        _steer,
    ),
    Claim("2.6", "The runs have K_v = [40 50 0].", GAIN_RUNS, _find_gains),
    Claim(
        "2.5.1.1",
        "The body-fixed forces of (2.17) can use the errors in earth-fixed axes, (2.13)-(2.16).",
        (*MIXED_FROM, PD_60, APD_60),
        _use_printed_frames,
    ),
    Claim(
        "2.4.2",
        "The drag of (2.10), with the squares of the velocities, brakes the vehicle.",
        (PRINTED_DRAG_FAR, REAL_DRAG_FAR),
        _brake,
    ),
)
