"""The claims of chapter 5 about its flocks, judged from runs."""

from __future__ import annotations

import numpy as np

from auv_experiment.confidence.binomial import share_words
from auv_experiment.metrics.consensus_bound import flock_metrics
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.metrics.gathering import APPROACH_MEAN_AFTER_S
from auv_experiment.metrics.windows import SETTLED_AFTER_S
from auv_thesis.acoustics.estimation_runs import errors_of, rms_m
from auv_thesis.ch4_6.ch5_tables import settled_m
from auv_thesis.ch4_6.flock_runs import (
    AS_PRINTED_ON,
    BLIND,
    DRAWN,
    FOUR_LEADERS,
    MATCHED_ON,
    OBSTACLES,
    ON_A_MODEM,
    ON_A_MODEM_OBSTACLES,
    ONE_LEADER,
    RESTING,
    RESTING_BLIND,
    STARTS,
)
from auv_thesis.intervals import mean_bounds, mean_words
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Claim, Run, Verdict

FOLLOWS_WITHIN_M = 0.2
"""
A flock follows the path if its mean stays this near. The limit is ours: 2 % of the path's radius. Verdicts
are the same for any limit from 0.18 to 1.8 m.
"""
_BROKEN_UP_M = 4.0
_PRINTED_APPROACH_S = (2.9, 2.4)
_BANDS = (0.02, 0.05, 0.1, 0.2)
"""Shares of its late mean within which a distance counts as reached; the thesis names none."""


def _judge_flocking(runs: list[Run]) -> Verdict:
    settled, drawn = runs[:2], runs[2:]
    hits = sum(run.metrics["collision"] for run in runs)
    lags_m = [run.metrics["centroid_path_rms_m"] for run in settled]
    closest_m = min(run.metrics["pair_distance_min_m"] for run in runs)
    evidence = (
        f"centroid {lags_m[0]:.3f} m (four leaders) and {lags_m[1]:.3f} m (one leader, printed law) from the "
        f"path, rms, where {FOLLOWS_WITHIN_M:g} m is our limit; no two centres nearer than {closest_m:.3f} "
        f"m. From drawn starts {share_words(sum(run.metrics['collision'] for run in drawn), len(drawn))} "
        "collide"
    )
    return Verdict(HOLDS if not hits and max(lags_m) < FOLLOWS_WITHIN_M else DOES_NOT_HOLD, evidence)


def _judge_knowledge(runs: list[Run]) -> Verdict:
    printed_m, blind_m = (run.metrics["centroid_path_rms_m"] for run in runs)
    evidence = (
        f"(5.25) and (5.43) give followers the path's attraction. With it the flock is {printed_m:.3f} m "
        f"from the path (rms); without it, as the text says, {blind_m:.3f} m: it lags, since followers do "
        f"not learn the flock's velocity. One flight each; our limit is {FOLLOWS_WITHIN_M:g} m"
    )
    return Verdict(HOLDS if blind_m < FOLLOWS_WITHIN_M else DOES_NOT_HOLD, evidence)


def _judge_spacing(runs: list[Run]) -> Verdict:
    spacing_m = runs[0].scenario.agent.flocking.params.spacing_m if runs[0].scenario.agent.flocking else 0.0
    lows = [settled_m(run)[0] for run in runs]
    evidence = (
        f"d = {spacing_m:g} m; smallest distance after 100 s {lows[0]:.3f} m (four leaders), {lows[1]:.3f} m "
        "(one leader). Repulsion ends at d and attraction does not, so the equilibrium distance is below d, "
        "from any start"
    )
    return Verdict(HOLDS if min(lows) >= spacing_m else DOES_NOT_HOLD, evidence)


def reached_s(run: Run, band: float) -> float:
    """Return when all distances are within a share of their means after 20 s for good (s)."""
    t_s, distances_m = run.recording.t_s, pair_distances_m(run.recording)
    mean_m = distances_m[t_s > APPROACH_MEAN_AFTER_S].mean(axis=0)
    is_out = (np.abs(distances_m - mean_m) > band * mean_m).any(axis=1)
    return float(t_s[np.flatnonzero(is_out)[-1] + 1])


def _judge_approach(runs: list[Run]) -> Verdict:
    """Judge whether the mean time from starts as far apart as the thesis's may be as short as it prints."""
    standard, drawn = runs[:2], runs[2:]
    groups = (drawn[:STARTS], drawn[STARTS:])
    words, in_time = [], []
    for name, printed_s, run, group in zip(
        ("four leaders", "one leader"), _PRINTED_APPROACH_S, standard, groups, strict=True
    ):
        by_band_s = [reached_s(run, band) for band in _BANDS]
        times_s = [float(one.metrics["approach_time_2pct_s"]) for one in group]
        within = sum(time_s <= printed_s for time_s in times_s)
        in_time.append(mean_bounds(times_s)[0] <= printed_s)
        words.append(
            f"{name}, printed {printed_s:g} s: {', '.join(f'{time_s:.1f}' for time_s in by_band_s)} s to "
            f"{', '.join(f'{100 * band:g}' for band in _BANDS)} % of the final distances from our standard "
            f"start; to 2 % {mean_words(times_s, 's')} from drawn starts, "
            f"{share_words(within, len(times_s))} in time"
        )
    evidence = (
        f"{'; '.join(words)}. The farthest pair starts 23 m apart in the standard start and 18 to 20 m in "
        "the drawn ones, as on the axis of Fig. 5.6a. The thesis prints neither its starts nor its band, and "
        "also counts the time to the path"
    )
    return Verdict(HOLDS if all(in_time) else HOLDS_IN_PART if any(in_time) else DOES_NOT_HOLD, evidence)


def _judge_obstacles(runs: list[Run]) -> Verdict:
    run = runs[0]
    clear_m, touch_m = run.metrics["obstacle_clearance_min_m"], run.scenario.hull_radius_m
    evidence = (
        f"no centre nearer than {clear_m:.3f} m to an obstacle's centre; hulls have a radius of {touch_m:g} "
        f"m, obstacles are points; no two centres nearer than {run.metrics['pair_distance_min_m']:.3f} m. "
        "One flight past two obstacles, whose places are those of the thesis"
    )
    return Verdict(HOLDS if clear_m > touch_m and not run.metrics["collision"] else DOES_NOT_HOLD, evidence)


def _judge_modem(runs: list[Run]) -> Verdict:
    figures, rest = runs[:2], runs[2:]
    printed, matched = rest[: len(AS_PRINTED_ON)], rest[len(AS_PRINTED_ON) :]
    slow = [run for (slot_s, _), run in zip(AS_PRINTED_ON, printed, strict=True) if slot_s >= 0.5]
    hits = sum(run.metrics["collision"] for run in slow)
    matched_hits = sum(run.metrics["collision"] for run in matched)
    bears = not any(run.metrics["collision"] for run in figures)
    clear_m = min(run.metrics["obstacle_clearance_min_m"] for run in figures)
    evidence = (
        f"with 2.5 reports a second and 30 % lost it {'passes' if bears else 'fails at'} the obstacles "
        f"({clear_m:.2f} m). With slots of 0.5 and 2 s, as real modems need, it collides in {hits} of "
        f"{len(slow)} cases; with feedback and consensus twenty times slower in {matched_hits} of "
        f"{len(matched)}. One draw of losses per case; A.41 and A.42 have many"
    )
    return Verdict(HOLDS_IN_PART if bears and hits else HOLDS if bears else DOES_NOT_HOLD, evidence)


def _judge_estimates(runs: list[Run]) -> Verdict:
    """Judge whether the filter is better than two estimators without one, on the packets of the flight."""
    words, better = [], []
    for run in runs:
        errors = errors_of(run).between(SETTLED_AFTER_S, run.scenario.duration_s)
        filter_mm, held_mm, reckoned_mm = (
            1e3 * rms_m(part) for part in (errors.ekf_m, errors.hold_m, errors.reckoned_m)
        )
        better += [filter_mm < held_mm, filter_mm < reckoned_mm]
        words.append(
            f"{run.scenario.name}: filter {filter_mm:.0f} mm, last packet held {held_mm:.0f} mm, dead "
            f"reckoned {reckoned_mm:.0f} mm"
        )
    ages_s = [run.metrics["neighbour_age_mean_s"] for run in runs]
    inside = [run.metrics["neighbour_within_2sigma_ratio"] for run in runs]
    evidence = (
        f"rms error of a neighbour after {SETTLED_AFTER_S:g} s: {'; '.join(words)}. Information is "
        f"{max(ages_s):.2f} s old on average; {100 * min(inside):.0f} % of the components are within two of "
        "the filters' own standard deviations. One flight each with exact navigation; A.31 to A.34 have "
        "slower channels, drift and more draws"
    )
    return Verdict(HOLDS if all(better) else HOLDS_IN_PART if any(better) else DOES_NOT_HOLD, evidence)


def _judge_consensus(runs: list[Run]) -> Verdict:
    moving, resting = runs
    bound = flock_metrics(moving.recording, moving.scenario)
    final = resting.recording
    mean = final.position_ned_m[-2].mean(axis=0)
    error_m = np.linalg.norm(final.centre_ned_m[-1] - mean, axis=1)
    bias_m = np.linalg.norm(final.position_ned_m[-2] - mean, axis=1) / (final.n_vehicles + 1)
    moving_m = moving.metrics["consensus_error_max_m"]
    evidence = (
        f"on the moving path up to {moving_m:.3f} m from the mean; at rest each estimate stays"
        f" {error_m.max():.3f} m off, a fifth of the way to its own vehicle "
        f"({bias_m.max():.3f} m). The bound (6.18) {'holds' if bound['consensus_bound_holds'] else 'fails'}: "
        f"|e| is at most {bound['consensus_error_norm_settled_m']:.2f} m where it allows "
        f"{bound['consensus_bound_radius_settled_m']:.2f} m"
    )
    return Verdict(DOES_NOT_HOLD if error_m.max() > 0.01 else HOLDS, evidence)


def _judge_range(runs: list[Run]) -> Verdict:
    largest_m = [float(pair_distances_m(run.recording)[run.recording.t_s > 100.0].max()) for run in runs]
    evidence = (
        f"largest distance after 100 s: {', '.join(f'{distance_m:.2f} m' for distance_m in largest_m)}. The "
        f"thesis names no largest distance; ours is {_BROKEN_UP_M:g} m, twice d. One flight each, and every "
        "vehicle knows every other at any range"
    )
    return Verdict(HOLDS if max(largest_m) < _BROKEN_UP_M else DOES_NOT_HOLD, evidence)


def judge_potential(runs: list[Run]) -> Verdict:
    """
    Judge whether the flock's potential decreases until the flock rests, with a moving path and a path at
    rest.
    """
    words, printed = [], []
    for run in runs:
        numbers = flock_metrics(run.recording, run.scenario)
        path = run.scenario.reference_of()
        rest = " at rest" if path is not None and path.period_s is None else ""
        parts = []
        for name in ("thesis", "corrected"):
            first_s = numbers[f"flock_lyapunov_{name}_first_rise_s"]
            parts.append(
                f"{name} " + ("always decreases" if first_s is None else f"increases from {first_s:.1f} s")
            )
        printed.append(bool(numbers["flock_lyapunov_thesis_falls"]))
        words.append(f"{run.scenario.name}{rest}: {', '.join(parts)}")
    verdict = HOLDS if all(printed) else HOLDS_IN_PART if any(printed) else DOES_NOT_HOLD
    return Verdict(verdict, "; ".join(words))


CLAIMS = (
    Claim(
        "5.8.1",
        "The vehicles flock along the path without collision.",
        (FOUR_LEADERS, ONE_LEADER, *DRAWN[FOUR_LEADERS], *DRAWN[ONE_LEADER]),
        _judge_flocking,
    ),
    Claim(
        "5.1",
        "Followers do not know the path, and follow it with the leader.",
        (ONE_LEADER, BLIND),
        _judge_knowledge,
    ),
    Claim(
        "5.3",
        "Distances stay above the safety distance d.",
        (FOUR_LEADERS, ONE_LEADER),
        _judge_spacing,
    ),
    Claim(
        "5.3",
        "Distances stay below a largest one, so that the group does not break up.",
        (FOUR_LEADERS, ONE_LEADER, BLIND, OBSTACLES),
        _judge_range,
    ),
    Claim(
        "5.8.1",
        "The flock forms within 2.9 s (four leaders) and 2.4 s (one leader).",
        (FOUR_LEADERS, ONE_LEADER, *DRAWN[FOUR_LEADERS], *DRAWN[ONE_LEADER]),
        _judge_approach,
    ),
    Claim(
        "5.5.2",
        "Every estimate of the flocking centre converges to the mean position.",
        (FOUR_LEADERS, RESTING),
        _judge_consensus,
    ),
    Claim("5.8.3", "The flock passes the obstacles without collision.", (OBSTACLES,), _judge_obstacles),
    Claim(
        "5.8.4",
        "The law keeps its flock under the communication limits of the sea.",
        (ON_A_MODEM, ON_A_MODEM_OBSTACLES, *AS_PRINTED_ON.values(), *MATCHED_ON.values()),
        _judge_modem,
    ),
    Claim(
        "5.7",
        "An extended Kalman filter compensates for lost and late reports.",
        (ON_A_MODEM, ON_A_MODEM_OBSTACLES),
        _judge_estimates,
    ),
    Claim(
        "5.6",
        "The potential of the closed loop decreases (promised there, argued in 6.5).",
        (FOUR_LEADERS, BLIND, RESTING, RESTING_BLIND),
        judge_potential,
    ),
)
