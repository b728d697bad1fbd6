"""
The estimators of neighbours side by side: error, consistency and computing time, on the same measurements.

The thesis (Eqs. (5.29)-(5.35)) names an extended Kalman filter and no program.  Here ours, the extended and
the unscented filter of filterpy get the packets of the same flights, and packets, sonar contacts and drifts
of the same synthetic neighbour.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from auv_core.compiled import use_compiler
from auv_core.params import load_section
from auv_core.plugins import list_plugins
from auv_flocking.neighbours.filter import ESTIMATORS, NeighbourConfig
from auv_flocking.neighbours.synthetic_neighbour import Instant, Setting, fly
from auv_flocking.neighbours.table import NeighbourTable
from auv_thesis.acoustics.estimation_in_flight import RUNS
from auv_thesis.acoustics.estimation_runs import BAR, Errors, errors_of, rms_m
from auv_thesis.intervals import mean_bounds
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, NO_NUMBER, Claim, Row, Run, Table, Verdict

KINDS = tuple(list_plugins(ESTIMATORS))
_CONFIG = NeighbourConfig(acceleration_memory_s=60.0, timeout_s=300.0)
_FLIGHTS = {"0.5 s slots": RUNS["exact navigation"][:3], "2 s slots": BAR}
_ALL = tuple(spec for flights in _FLIGHTS.values() for spec in flights)
_SETTING = Setting(loss_prob=0.3, sonar_every_s=0.5, own_rate_mps=0.0075, sender_rate_mps=0.0075)
_SEED, _RUNS, _DURATION_S = 37, 6, 60.0
_AGREEMENT = 1e-9


class Measured(NamedTuple):
    """Of the runs of one estimator: rms errors (m), mean NEES of position, and times of a tick (us)."""

    errors_m: list[float]
    nees: list[float]
    ticks_us: list[float]


def config_of(kind: str) -> NeighbourConfig:
    """Return constant velocity with a density that follows, and another estimator."""
    return replace(_CONFIG, estimator=load_section({"kind": kind}, "estimator", ESTIMATORS))


@cache
def _synthetic_of(kind: str) -> Measured:
    """Return what an estimator does with packets, sonar contacts and drift of one neighbour."""
    use_compiler()
    found = Measured([], [], [])
    for seed in np.random.SeedSequence(_SEED).spawn(_RUNS):
        instants = list(fly(_SETTING, _CONFIG, np.random.default_rng(seed), _DURATION_S))
        errors_m, nees, tick_us = _one_run(config_of(kind), instants)
        found.errors_m.append(errors_m)
        found.nees.append(nees)
        found.ticks_us.append(tick_us)
    return found


def _one_run(config: NeighbourConfig, instants: list[Instant]) -> tuple[float, float, float]:
    table, squares_m2, nees = NeighbourTable(config), [], []
    spent_s = 0.0
    for now in instants:
        started_s = time.perf_counter()
        for report in now.reports:
            table.receive(report)
        table.observe(now.t_s, now.nav, now.contacts)
        estimates = table.estimates(now.t_s, now.nav)
        spent_s += time.perf_counter() - started_s
        for estimate in estimates:
            error_m = np.array(estimate.position) - now.truth[:3]
            squares_m2.append(error_m @ error_m)
            nees.append(error_m @ np.linalg.solve(estimate.covariance[:3, :3], error_m))
    return float(np.sqrt(np.mean(squares_m2))), float(np.mean(nees)), 1e6 * spent_s / len(instants)


def _words(numbers: list[float], digits: int) -> str:
    low, high = mean_bounds(numbers)
    return f"{np.mean(numbers):.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _flight_rows(runs: list[Run]) -> list[Row]:
    rows, first = [], 0
    for cell, flights in _FLIGHTS.items():
        part = runs[first : first + len(flights)]
        first += len(flights)
        for kind in KINDS:
            errors = [errors_of(run, config_of(kind)) for run in part]
            words = (
                f"error {_words([rms_m(each.ekf_m) for each in errors], 3)} m, "
                f"NEES of position {_words([each.nees for each in errors], 2)}"
            )
            rows.append(
                Row(
                    f"{kind}: flock, {cell}, 30 % lost", "not given", words, NO_NUMBER, f"{len(part)} flights"
                )
            )
    return rows


def _synthetic_rows() -> list[Row]:
    rows = []
    usual_us = float(np.median(_synthetic_of("ekf").ticks_us))
    for kind in KINDS:
        found = _synthetic_of(kind)
        tick_us = float(np.median(found.ticks_us))
        words = (
            f"error {_words(found.errors_m, 3)} m, NEES of position {_words(found.nees, 2)}, "
            f"{tick_us:.0f} us a tick, {tick_us / usual_us:.1f} times ekf's"
        )
        rows.append(Row(f"{kind}: packets, sonar and drift", "not given", words, NO_NUMBER, f"{_RUNS} runs"))
    return rows


def _rows(runs: list[Run]) -> list[Row]:
    return _flight_rows(runs) + _synthetic_rows()


def _judge(runs: list[Run]) -> Verdict:
    apart = max(
        _apart(errors_of(run, config_of("ekf")), errors_of(run, config_of("filterpy_ekf"))) for run in runs
    )
    evidence = f"largest difference of position and variance {apart:.1g} m or m^2 in {len(runs)} flights"
    return Verdict(HOLDS if apart < _AGREEMENT else DOES_NOT_HOLD, evidence)


def _apart(one: Errors, other: Errors) -> float:
    """Return the largest difference of positions (m) and their covariances (m^2)."""
    differences: tuple[Callable[[Errors], np.ndarray], ...] = (lambda e: e.ekf_m, lambda e: e.covariance)
    return max(float(np.abs(part(one) - part(other)).max()) for part in differences)


TABLES = (
    Table("A.37", "Estimators of a neighbour, on the same measurements", _ALL, _rows, "consistent: NEES 3"),
)

CLAIMS = (
    Claim(
        "A.37",
        "Our filter gives the numbers of filterpy's extended Kalman filter within 1e-9, on the packets of "
        "flights (ours).",
        _FLIGHTS["0.5 s slots"][:1] + _FLIGHTS["2 s slots"][:1],
        _judge,
    ),
)
