"""
Our tables for chapter 5: distances marked in its figures, its flocks in numbers, its law on real channels.
"""

from __future__ import annotations

from auv_experiment.metrics.consensus_bound import flock_metrics
from auv_thesis.ch4_6.flock_runs import (
    AS_PRINTED_ON,
    BLIND,
    FOUR_LEADERS,
    MATCHED_ON,
    OBSTACLES,
    ON_A_MODEM,
    ON_A_MODEM_OBSTACLES,
    ONE_LEADER,
)
from auv_thesis.items import AGREES, DIFFERS, NO_NUMBER, Row, Run, Table

NEAR_RATIO = 0.02
"""A distance agrees within 2 %, the band of the thesis's approach time."""

_CASES = ("four leaders", "one leader, printed followers", "one leader, blind followers", "obstacles")


def mean_distance_m(run: Run) -> float:
    """Return the middle of the settled distances (m)."""
    low_m, high_m = settled_m(run)
    return 0.5 * (low_m + high_m)


def settled_m(run: Run) -> tuple[float, float]:
    """Return the smallest and the largest distance after 100 s (m)."""
    return (run.metrics["pair_distance_settled_min_m"], run.metrics["pair_distance_settled_max_m"])


def marker_row(quantity: str, printed_m: float, run: Run) -> Row:
    """Return the row of a distance that is marked in a figure of the thesis."""
    ours_m = mean_distance_m(run)
    near = abs(ours_m - printed_m) <= NEAR_RATIO * printed_m
    note = f"{1e3 * (ours_m - printed_m):+.1f} mm; with k_c = k_d = 1, not the 10 of the text"
    return Row(quantity, f"{printed_m:g} m", f"{ours_m:.4f} m", AGREES if near else DIFFERS, note)


def seconds(value: float | None) -> str:
    """Return a time as text."""
    return "never" if value is None else f"{value:.2f} s"


def _rows_5_a(runs: list[Run]) -> list[Row]:
    four, one, *_ = runs
    rows = [
        marker_row("distance marked in Fig. 5.6c", 1.595, four),
        marker_row("distance marked in Fig. 5.8b", 1.596, one),
    ]
    for name, run in zip(_CASES, runs, strict=True):
        rows += flock_rows(name, run)
    return rows


def flock_rows(name: str, run: Run) -> list[Row]:
    """Return numbers of our flocks for which the thesis has no counterpart."""
    numbers, (low_m, high_m) = run.metrics, settled_m(run)
    ours = {
        "distances after 100 s": f"{low_m:.4f} to {high_m:.4f} m",
        "smallest distance ever": f"{numbers['pair_distance_min_m']:.3f} m",
        "centroid to path, rms after 100 s": f"{numbers['centroid_path_rms_m']:.4f} m",
        "consensus error, largest after 100 s": f"{numbers['consensus_error_max_m']:.4f} m",
    }
    if numbers["approach_time_2pct_s"] is not None and not run.scenario.environment.obstacles:
        ours["approach to 2 %"] = seconds(numbers["approach_time_2pct_s"])
    if numbers["obstacle_clearance_min_m"] is not None:
        ours["smallest distance to an obstacle"] = f"{numbers['obstacle_clearance_min_m']:.3f} m"
    return [Row(f"{name}: {quantity}", "not given", value, NO_NUMBER) for quantity, value in ours.items()]


def _rows_5_b(runs: list[Run]) -> list[Row]:
    rows = []
    slots = list(AS_PRINTED_ON) + list(MATCHED_ON)
    for index, ((slot_s, loss), run) in enumerate(zip(slots, runs, strict=True)):
        law = "thesis's gains" if index < len(AS_PRINTED_ON) else "twenty times slower"
        numbers = run.metrics
        touch_m = 2.0 * run.scenario.hull_radius_m
        closest_m = numbers["pair_distance_min_m"]
        known = f"information {numbers['neighbour_age_mean_s']:.1f} s old on average"
        rows.append(
            Row(
                f"{law}, slots of {slot_s:g} s, {100 * loss:.0f} % lost: smallest distance",
                "no collision, no number",
                f"{closest_m:.2f} m" + (" (collision)" if numbers["collision"] else ""),
                DIFFERS if numbers["collision"] else AGREES,
                f"{known}; hulls touch at {touch_m:g} m",
            )
        )
    return rows


def _rows_5_c(runs: list[Run]) -> list[Row]:
    rows = []
    names = ("four leaders", "blind followers", "fast modem, one obstacle", "fast modem, two obstacles")
    for name, run in zip(names, runs, strict=True):
        numbers = flock_metrics(run.recording, run.scenario)
        holds = numbers["consensus_bound_holds"]
        rows.append(
            Row(
                f"{name}: V_dot <= -|e|^2 + |e| n rho",
                "for every run",
                f"{'holds' if holds else 'fails'}, by {numbers['consensus_bound_margin_m2ps']:.2f} m^2/s",
                AGREES if holds else DIFFERS,
                f"rho = {numbers['consensus_rho_mps']:.2f} m/s in the whole run",
            )
        )
        error_m, radius_m = (
            numbers["consensus_error_norm_settled_m"],
            numbers["consensus_bound_radius_settled_m"],
        )
        rows.append(
            Row(
                f"{name}: |e| after 100 s",
                "goes to 0",
                f"at most {error_m:.3f} m, under n rho = {radius_m:.2f} m",
                DIFFERS,
                f"rho = {numbers['consensus_rho_settled_mps']:.2f} m/s after 100 s; e stacked over vehicles",
            )
        )
    return rows


TABLES = (
    Table(
        "5.A",
        "Flocks with mathematical potentials, continuous in time",
        (FOUR_LEADERS, ONE_LEADER, BLIND, OBSTACLES),
        _rows_5_a,
    ),
    Table(
        "5.B",
        "The thesis's law on acoustic channels, without obstacles",
        (*AS_PRINTED_ON.values(), *MATCHED_ON.values()),
        _rows_5_b,
    ),
    Table(
        "5.C",
        "The bound (6.18) on the consensus error along runs",
        (FOUR_LEADERS, BLIND, ON_A_MODEM, ON_A_MODEM_OBSTACLES),
        _rows_5_c,
    ),
)
