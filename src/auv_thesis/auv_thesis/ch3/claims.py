"""The claims of chapter 3, judged from our runs."""

from __future__ import annotations

import numpy as np

from auv_experiment.metrics.formations.errors import rate_errors
from auv_thesis.ch3.runs import (
    CIRCLE,
    CIRCLE_CORRECTED,
    CIRCLE_OFF,
    CORRECTED_LATE_S,
    CORRECTED_PATHS,
    CROSSING,
    OFF_BY,
    PRINTED_LATE_S,
    SPIRAL,
    WIND_UP,
    corrected_runs,
    estimate,
    late_errors_m,
    late_rms_m,
    printed_runs,
)
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Claim, Run, Verdict

_ZERO_ON_PAPER = 0.01
"""Fraction of an axis below which a printed curve cannot be distinguished from zero; the limit is ours."""
_COMPENSATES, _HELPS = 0.2, 0.8
"""Shares of the error that may remain if adaptation compensates for it, or helps; ours."""


def _errors_vanish(runs: list[Run]) -> Verdict:
    late_mm = [1e3 * x for x in late_errors_m(runs[0], 100.0)]
    worst_mm = max(late_mm[:3])
    words = f"after 100 s at most {worst_mm:.2f} mm with exact initial estimates"
    low_mm = 1e3 * late_rms_m(runs[1], PRINTED_LATE_S)
    words += f"; with initial estimates of 0.7 of the true values AUV3 keeps an error of {low_mm:.1f} mm rms"
    if max(worst_mm, low_mm) < 1e-3:
        return Verdict(HOLDS, words)
    return Verdict(HOLDS_IN_PART if worst_mm < 1e3 * _ZERO_ON_PAPER * 12.0 else DOES_NOT_HOLD, words)


def _rates_vanish(runs: list[Run]) -> Verdict:
    late = np.abs(rate_errors(runs[0].recording, runs[0].scenario))[runs[0].recording.t_s >= 100.0]
    worst_mmps = 1e3 * float(late.max())
    frame = runs[0].scenario.vehicles[0].model.params.frame
    words = f"after 100 s at most {worst_mmps:.3f} mm/s; plotted are rates in NED (frame {frame}), J = I"
    return Verdict(HOLDS_IN_PART if worst_mmps < 1e3 * _ZERO_ON_PAPER * 9.0 else DOES_NOT_HOLD, words)


def _forces_vanish(runs: list[Run]) -> Verdict:
    m = runs[0].metrics
    late_n = (m["x_force_late_n"], m["y_force_late_n"])
    words = f"after 100 s X and Y still reach {late_n[0]:.2f} and {late_n[1]:.2f} N, once per round"
    z_n = runs[1].metrics["z_force_late_n"]
    words += f"; in the spiral Z stays at {z_n:.1f} N"
    return Verdict(HOLDS if max(*late_n, z_n) < 1e-3 else DOES_NOT_HOLD, words)


def _distances_hold(runs: list[Run]) -> Verdict:
    m = runs[0].metrics
    late_m = max(m["d12_err_late_m"], m["d23_err_late_m"])
    settled_s = (m["d12_settling_0p05_s"], m["d23_settling_0p05_s"])
    if None in settled_s:
        return Verdict(DOES_NOT_HOLD, f"{1e3 * late_m:.1f} mm off 10 m after 100 s")
    words = f"within 5 cm of 10 m from {max(settled_s):.1f} s, within {1e3 * late_m:.1f} mm after 100 s"
    if runs[1:]:
        off_m = [max(run.metrics["d12_err_late_m"], run.metrics["d23_err_late_m"]) for run in runs[1:]]
        words += ", with exact initial estimates; with estimates of " + " and ".join(
            f"{ratio:g} of the true values within {1e3 * error_m:.1f} mm"
            for ratio, error_m in zip(OFF_BY, off_m, strict=True)
        )
        late_m = max(late_m, *off_m)
    return Verdict(HOLDS if late_m < _ZERO_ON_PAPER * 12.0 else DOES_NOT_HOLD, words)


def _difference_vanishes(runs: list[Run]) -> Verdict:
    words, worst_m = [], 0.0
    for name, run in zip(("circle", "spiral"), runs[:2], strict=True):
        late_m = run.metrics["d12_minus_d23_late_m"]
        worst_m = max(worst_m, late_m)
        words.append(f"{name}: {1e3 * late_m:.1f} mm at most after 100 s")
    words.append("zero at the resolution of the thesis's axes, but not zero")
    return Verdict(HOLDS_IN_PART if worst_m < 0.05 else DOES_NOT_HOLD, "; ".join(words))


def _collisions_avoided(runs: list[Run]) -> Verdict:
    run = runs[0]
    closest_m = run.metrics["pair_distance_min_m"]
    if not run.metrics["collision"]:
        return Verdict(
            HOLDS_IN_PART, f"hulls stay at least {closest_m:.2f} m apart; the law has no term for this"
        )
    return Verdict(
        DOES_NOT_HOLD,
        f"two vehicles that start on each other's side collide after {run.metrics['collision_at_s']:.2f} s "
        f"(centres {closest_m:.2f} m apart): no vehicle knows the others' positions",
    )


def _spiral_force(runs: list[Run]) -> Verdict:
    high_n = runs[0].metrics["force_range_n"][1]
    holds = HOLDS if 35000.0 < high_n <= 40000.0 else DOES_NOT_HOLD
    return Verdict(
        holds,
        f"our largest is {high_n:.0f} N; with errors of at most 10 m, K_D Λ e of Table 3.1 is at most 10 kN, "
        "and that in z, which starts without an error",
    )


def _stable_by_lyapunov(runs: list[Run]) -> Verdict:
    printed, corrected = (run.metrics for run in runs)
    falls = bool(corrected["lyapunov_corrected_falls"])
    words = "as printed and simulated, (3.21) "
    if printed["lyapunov_thesis_falls"]:
        words += "never rises"
    else:
        words += (
            f"increases in {100 * printed['lyapunov_thesis_rise_ratio']:.0f} % of the records, first at "
            f"{printed['lyapunov_thesis_first_rise_s']:.1f} s: {printed['lyapunov_proof_gap']}"
        )
    words += (
        "; of the corrected law V "
        + ("decreases in every record" if falls else "increases in some records")
        + f", and (3.21) increases in {100 * corrected['lyapunov_thesis_rise_ratio']:.0f} %"
    )
    if printed["lyapunov_thesis_falls"] and falls:
        return Verdict(HOLDS, words)
    return Verdict(HOLDS_IN_PART if falls else DOES_NOT_HOLD, words)


def _gamma_definite(runs: list[Run]) -> Verdict:
    law = runs[0].scenario.agent.controller.params
    gains = (*law.inertia_adaptation, *law.quadratic_adaptation)
    zeros = sum(gain == 0.0 for gain in gains)
    words = f"{zeros} of the {len(gains)} numbers of Table 3.1 are zero: Γ^-1 of (3.21) does not exist"
    return Verdict(DOES_NOT_HOLD if zeros else HOLDS, words)


def _adaptation_compensates(runs: list[Run]) -> Verdict:
    """Judge the law as printed, by the share of the error that adaptation leaves."""
    printed, corrected = runs[:4], runs[4:]
    errors_mm = [1e3 * late_rms_m(run, PRINTED_LATE_S) for run in printed]
    body_fixed, body_adaptive = (1e3 * late_rms_m(run, CORRECTED_LATE_S) for run in corrected)
    left = [adaptive / fixed for fixed, adaptive in zip(errors_mm[::2], errors_mm[1::2], strict=True)]
    cases = "; ".join(
        f"{ratio:g} of the true values {errors_mm[2 * i]:.1f} mm without adaptation, "
        f"{errors_mm[2 * i + 1]:.1f} mm with it ({100.0 * left[i]:.0f} % left)"
        for i, ratio in enumerate(OFF_BY)
    )
    words = (
        f"circle of 30 m, initial estimates of {cases}; our limits are {100 * _COMPENSATES:.0f} and "
        f"{100 * _HELPS:.0f} %. Corrected law at 0.05 rad/s: {body_fixed:.0f} and {body_adaptive:.1f} mm"
    )
    if max(left) < _COMPENSATES:
        return Verdict(HOLDS, words)
    return Verdict(HOLDS_IN_PART if max(left) < _HELPS else DOES_NOT_HOLD, words)


def _estimates_mean_something(runs: list[Run]) -> Verdict:
    mass_kg = estimate(runs[0], "m22", 20.0)
    words = f"m22 of AUV3 starts at 0.7 of its 108.5 kg and is {mass_kg:.1f} kg after 20 s"
    return Verdict(HOLDS if abs(mass_kg / 108.5 - 1.0) < 0.3 else DOES_NOT_HOLD, words)


_LOW_PRINTED = printed_runs(OFF_BY[0])
_LOW_CORRECTED = corrected_runs(*CORRECTED_PATHS["circle R = 30 m, 0.05 rad/s"])

CLAIMS = (
    Claim("Fig. 3.6", "Velocity errors of AUV1 go to zero, in the body frame.", (CIRCLE,), _rates_vanish),
    Claim("Fig. 3.5", "Position errors of AUV1 go to zero.", (CIRCLE, _LOW_PRINTED[1]), _errors_vanish),
    Claim(
        "Fig. 3.7",
        "Once on their tracks the vehicles need no force, and their velocities are constant.",
        (CIRCLE, SPIRAL),
        _forces_vanish,
    ),
    Claim(
        "Fig. 3.8",
        "AUV1 and AUV2, AUV2 and AUV3 stay 10 m apart, circle.",
        (CIRCLE, *CIRCLE_OFF),
        _distances_hold,
    ),
    Claim("Fig. 3.9", "The two distances do not differ.", (CIRCLE, SPIRAL), _difference_vanishes),
    Claim(
        "Section 3.5.1", "Equal distances are kept and collisions avoided.", (CROSSING,), _collisions_avoided
    ),
    Claim("Fig. 3.12", "The spiral takes forces of up to 35 kN.", (SPIRAL,), _spiral_force),
    Claim("Fig. 3.13", "AUV1 and AUV2, AUV2 and AUV3 stay 10 m apart, spiral.", (SPIRAL,), _distances_hold),
    Claim(
        "Eq. (3.36)",
        "The law is stable, since V of (3.21) decreases.",
        (CIRCLE, CIRCLE_CORRECTED),
        _stable_by_lyapunov,
    ),
    Claim("Eq. (3.12)", "Γ is positive definite.", (CIRCLE,), _gamma_definite),
    Claim(
        "Section 3.4.2",
        "Adaptation compensates for unknown hydrodynamics.",
        (*_LOW_PRINTED[:2], *printed_runs(OFF_BY[1])[:2], *_LOW_CORRECTED[1:3]),
        _adaptation_compensates,
    ),
    Claim(
        "Section 3.4.2",
        "The law estimates the vehicle's parameters.",
        (WIND_UP[1],),
        _estimates_mean_something,
    ),
)
