"""Table 3.F: what the parameter estimates of the adaptive law become, without and with noise."""

from __future__ import annotations

from collections.abc import Sequence

from auv_thesis.cases import by_case
from auv_thesis.ch3.runs import CIRCLE, DRIFT_RUNS, DRIFT_S, WIND_UP, estimate, late_rms_m
from auv_thesis.intervals import mean_words
from auv_thesis.items import NO_NUMBER, Row, Run, Table

NOTHING = "-"


def _estimates(runs: list[Run]) -> list[Row]:
    circle, nominal, low, *drift = runs
    masses = [estimate(circle, "m22", 20.0, vehicle) for vehicle in range(3)]
    rows = [
        Row(
            "as printed: m22 of AUV1, AUV2, AUV3 after 20 s",
            NOTHING,
            ", ".join(f"{mass:.1f}" for mass in masses) + " kg",
            NO_NUMBER,
            "108.5 kg is correct and was the initial estimate.",
        ),
        Row(
            "the same, AUV3 from the origin, initially 1.0 and 0.7 of the true values",
            NOTHING,
            f"{estimate(nominal, 'm22', 20.0):.1f}, {estimate(low, 'm22', 20.0):.1f} kg",
            NO_NUMBER,
            "The initial errors wind it up, and no term brings it back.",
        ),
    ]
    rows += [_drift_row(name, drawn) for name, drawn in by_case(DRIFT_RUNS, drift).items()]
    return rows


def _drift_row(name: str, runs: Sequence[Run]) -> Row:
    at = [[estimate(run, "m11", share * DRIFT_S) for run in runs] for share in (0.25, 0.5, 1.0)]
    late_mm = [1e3 * late_rms_m(run, DRIFT_S / 2.0) for run in runs]
    return Row(
        f"corrected, noise, {name}: m11 after 1/4, 1/2 and all of {DRIFT_S:g} s",
        NOTHING,
        f"{', '.join(mean_words(masses, 'kg', 0) for masses in at)}; rms {mean_words(late_mm, 'mm', 1)}",
        NO_NUMBER,
        f"n = {len(runs)}; 99 kg is correct; noise of 5 cm and 5 cm/s, drawn every 0.05 s.",
    )


TABLES = (
    Table(
        "3.F",
        "Parameter estimates over time",
        (CIRCLE, *WIND_UP, *(spec for specs in DRIFT_RUNS.values() for spec in specs)),
        _estimates,
    ),
)
