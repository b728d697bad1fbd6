"""Answers to simple questions about a run."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

from auv_experiment.metrics.distances import touch_distances_m
from auv_experiment.metrics.gathering import formed_within_m
from auv_experiment.metrics.safety import near_warning, surface_warning
from auv_experiment.recording import FloatArray
from auv_experiment.scenario.teams import team_scenarios

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_CONSISTENT_SHARE = (0.90, 0.985)


def verdicts(scenario: Scenario, metrics: dict[str, Any]) -> list[str]:
    """Return the answers, each with its number."""
    get = metrics.get
    answers = []
    nearest_m = get("pair_distance_min_m")
    if nearest_m is not None:
        touch = " to ".join(f"{touch_m:g}" for touch_m in sorted({*_range(touch_distances_m(scenario))}))
        detail = f"Smallest distance of two hull centres {nearest_m:.2f} m; hulls touch at {touch} m."
        if get("collision"):
            detail += f" First contact at {get('collision_at_s'):.1f} s."
        answers.append(_answer("Did hulls touch?", bool(get("collision")), detail, good=False))
    if get("near_pairs") is not None:
        answers.append(_near_answer(metrics))
    within_m = _formed_within_m(scenario)
    if nearest_m is not None and within_m is not None:
        answers.append(_formed_answer(metrics, within_m))
    if "fleet_formed_at_s" in metrics:
        answers.append(_fleet_answer(metrics))
    if surface_warning(metrics):
        answers.append(_answer("Did hulls leave the water?", True, surface_warning(metrics), good=False))
    farthest_m = get("pair_distance_formed_max_m")
    if farthest_m is not None and within_m is not None:
        detail = f"Once formed between {get('pair_distance_formed_min_m'):.2f} and {farthest_m:.2f} m apart."
        answers.append(_answer("Did the flock stay together?", farthest_m <= within_m, detail))
    clearance_m = get("obstacle_clearance_min_m")
    if clearance_m is not None:
        detail = (
            f"Smallest distance to an obstacle {clearance_m:.2f} m, hull radius {scenario.hull_radius_m:g} m."
        )
        answers.append(
            _answer("Did it keep clear of obstacles?", clearance_m > scenario.hull_radius_m, detail)
        )
    lost = get("lost_vehicles") or []
    answers.append(
        _answer("Did every vehicle reach the end?", not lost, f"Lost: {', '.join(lost)}." if lost else "")
    )
    share = get("neighbour_within_2sigma_ratio")
    if share is not None:
        answers.append(_consistency_answer(share))
    return answers


def _formed_within_m(scenario: Scenario) -> float | None:
    """Return the distance of a formed flock (m), None without a flock of two or more."""
    flock = next((team for team in team_scenarios(scenario) if team.agent.flocking is not None), None)
    return None if flock is None or len(flock.vehicles) < 2 else formed_within_m(flock)


def _answer(question: str, holds: bool, detail: str, *, good: bool = True) -> str:
    kind = "good" if holds is good else "bad"
    word = "Yes." if holds else "No."
    return f'<li class="{kind}">{html.escape(question)} <b>{word}</b> {html.escape(detail)}</li>'


def _range(touch_m: FloatArray) -> tuple[float, float]:
    return float(touch_m.min()), float(touch_m.max())


def _near_answer(metrics: dict[str, Any]) -> str:
    line = near_warning(metrics) or "no pair came nearer than near_m of its models"
    return _answer("Did vehicles keep their distance?", not metrics["near_pairs"], f"{line.capitalize()}.")


def _fleet_answer(metrics: dict[str, Any]) -> str:
    formed_at_s = metrics["fleet_formed_at_s"]
    detail = "At no time were all vehicles in their slots."
    if formed_at_s is not None:
        nearest_m = metrics.get("pair_distance_formed_min_m")
        apart = "" if nearest_m is None else f", from then on at least {nearest_m:.1f} m apart"
        detail = f"All vehicles were in their slots at {formed_at_s:.1f} s{apart}."
    return _answer("Did the fleet form?", formed_at_s is not None, detail)


def _formed_answer(metrics: dict[str, Any], within_m: float) -> str:
    formed_at_s = metrics.get("formed_at_s")
    near = f"within {within_m:g} m of each other for 10 s"
    detail = f"At no time had every pair been {near}."
    if formed_at_s is not None:
        detail = f"Every pair had been {near} at {formed_at_s:.1f} s."
    return _answer("Did the flock form?", formed_at_s is not None, detail)


def _consistency_answer(share: float) -> str:
    low, high = _CONSISTENT_SHARE
    judgement = "cautious: errors are smaller than stated" if share > high else "consistent"
    if share < low:
        judgement = "overconfident: errors are larger than stated"
    detail = f"{share:.3f} of the errors lie inside 2 sigma, 0.954 expected; the filters are {judgement}."
    return _answer("Do the filters cover their errors?", share >= low, detail)
