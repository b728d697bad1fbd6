"""
Repair after the loss of two of eight vehicles over acoustic links, with many seeds, against the bars.

A wedge loses its leader and a follower at once, with slots of 0.5 s and 30 % of the packets lost. Times count
from the time-out, after which a vehicle without news counts as lost. Distances are those of live vehicles.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from auv_experiment.confidence.binomial import share_words
from auv_thesis.formation.acoustic_runs import N_SEEDS, REPAIRS
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Row,
    Run,
    Table,
    Verdict,
)

AGREED_CYCLES, AGREED_SHARE = 3.0, 0.95
MARGIN_S, APART_M = 10.0, 1.0


class Times(NamedTuple):
    """Times of a scenario (s): when the time-out of the last loss ends, a cycle of the channel, a move."""

    timeout_s: float
    cycle_s: float
    move_s: float


def _times(run: Run) -> Times:
    scenario = run.scenario
    assert scenario.agent.flocking is not None
    law = scenario.agent.flocking.params
    lost_s = max(vehicle.fails_at_s or 0.0 for vehicle in scenario.vehicles)
    cycle_s = scenario.acoustics.mac.params.slot_s * len(scenario.vehicles)
    return Times(lost_s + law.lost_after_s, cycle_s, law.move_s)


def agreed_s(run: Run) -> float | None:
    """Return the time from the time-out to the agreement of all live vehicles on their slots (s)."""
    after_s: float | None = run.metrics["formation_agreed_after_s"]
    return None if after_s is None else max(0.0, after_s - _times(run).timeout_s)


def agrees_in_time(run: Run) -> bool:
    """Return whether all live vehicles hold the same slots three cycles after the time-out."""
    after_s = agreed_s(run)
    return after_s is not None and after_s <= AGREED_CYCLES * _times(run).cycle_s


def forms_in_time(run: Run) -> bool:
    """Return whether all are in formation T_s + 10 s after these three cycles."""
    times = _times(run)
    allowed_s = times.timeout_s + AGREED_CYCLES * times.cycle_s + times.move_s + MARGIN_S
    after_s = run.metrics["formation_in_place_after_s"]
    return after_s is not None and after_s <= allowed_s


def least_distance_m(runs: Sequence[Run]) -> float:
    """Return the smallest distance of two live vehicles in any of the runs (m)."""
    return min(float(run.metrics["pair_distance_working_min_m"]) for run in runs)


def _rows(runs: list[Run]) -> list[Row]:
    n = len(runs)
    agreed, formed = sum(map(agrees_in_time, runs)), sum(map(forms_in_time, runs))
    apart = sum(least_distance_m([run]) >= APART_M for run in runs)
    known_s = [after_s for run in runs if (after_s := agreed_s(run)) is not None]
    slowest = f"slowest of those that agree {max(known_s):.0f} s after it" if known_s else ""
    in_place_s = [run.metrics["formation_in_place_after_s"] for run in runs]
    last = "" if None in in_place_s else f"the last at {max(in_place_s):.0f} s"
    return [
        Row(
            "all live vehicles hold the same slots three cycles after the time-out",
            "95 %",
            share_words(agreed, n),
            _kept(agreed >= AGREED_SHARE * n, n),
            slowest,
        ),
        Row(
            f"and are within 0.5 m of them T_s + {MARGIN_S:g} s later",
            "all",
            share_words(formed, n),
            _kept(formed == n, n),
            last,
        ),
        Row(
            f"live vehicles stay {APART_M:g} m apart",
            "all",
            share_words(apart, n),
            _kept(apart == n, n),
            f"least distance {least_distance_m(runs):.2f} m",
        ),
        Row(
            "least distance to a lost vehicle (m)",
            "not given",
            f"{min(float(run.metrics['wreck_distance_min_m']) for run in runs):.2f}",
            NO_NUMBER,
        ),
    ]


def _kept(is_kept: bool, n: int) -> str:
    """Return the verdict on a bar, which few seeds keep in part only."""
    return DIFFERS if not is_kept else AGREES if n == N_SEEDS else AGREES_IN_PART


def _judge(runs: list[Run]) -> Verdict:
    n, agreed = len(runs), sum(map(agrees_in_time, runs))
    is_safe = least_distance_m(runs) >= APART_M
    keeps = agreed >= AGREED_SHARE * n and all(map(forms_in_time, runs)) and is_safe
    return Verdict(
        HOLDS if keeps else HOLDS_IN_PART if is_safe else DOES_NOT_HOLD,
        f"in time in {share_words(agreed, n)}, in formation in time in "
        f"{share_words(sum(map(forms_in_time, runs)), n)}; least distance of live vehicles "
        f"{least_distance_m(runs):.2f} m",
    )


TABLES = (Table("1.K", "Repair with many seeds", REPAIRS, _rows, "wanted"),)

CLAIMS = (
    Claim(
        "1.K",
        "Vehicles that notice a loss from silence alone agree on their new slots within three cycles (ours).",
        REPAIRS,
        _judge,
    ),
)
