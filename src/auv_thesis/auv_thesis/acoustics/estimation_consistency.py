"""
Consistency of the neighbour filter when the truth follows the filter's own model.

100 runs of 40 s per setting: white acceleration, a packet every second that is up to 1.5 s late and may
overtake others, sonar at 2 Hz, navigations that drift at constant rates, with and without fixes. The same
truth at several slot lengths and losses compares the errors with those of simpler estimators.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import legend_below, vehicle_style
from auv_flocking.neighbours.synthetic_neighbour import Setting, fly
from auv_flocking.neighbours.table import NeighbourConfig, NeighbourTable
from auv_flocking.report import Report
from auv_thesis.acoustics.consistency import CONTACT, PACKET, STATES, Squares, band, share_inside, squares
from auv_thesis.acoustics.estimation_runs import LOSSES, SLOTS_S
from auv_thesis.items import (
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    Table,
    Verdict,
)

_RUNS, _DURATION_S, _SEED = 100, 40.0, 33
_CONFIG = NeighbourConfig()
_RATE = _CONFIG.drift_rate_mps
_PLAIN, _SONAR = Setting(), Setting(sonar_every_s=0.5)
_DRIFT = Setting(own_rate_mps=_RATE, sender_rate_mps=_RATE)
_BOTH = Setting(own_rate_mps=_RATE, sender_rate_mps=_RATE, sonar_every_s=0.5)
_FIXES = Setting(
    own_rate_mps=_RATE,
    sender_rate_mps=_RATE,
    sonar_every_s=0.5,
    own_fixes_s=(13.0, 33.0),
    sender_fixes_s=(21.0, 27.0),
)
_SETTINGS = {
    "packets": _PLAIN,
    "packets and sonar": _SONAR,
    "packets, drift": _DRIFT,
    "packets and sonar, drift": _BOTH,
    "packets and sonar, drift and fixes": _FIXES,
}
_OWN_MODEL = ("packets", "packets and sonar", "packets, drift", "packets and sonar, drift")
_VEHICLES = 4
_ERROR_RUNS, _ERROR_S = 6, 200.0


@lru_cache(maxsize=len(_SETTINGS))
def _squares(name: str) -> Squares:
    seeds = np.random.SeedSequence(_SEED).spawn(_RUNS)
    return squares(_SETTINGS[name], _CONFIG, seeds, _DURATION_S)


def _shares(name: str) -> dict[str, tuple[float, float]]:
    """Return the mean of NEES and NIS and the share inside the interval, by kind."""
    found = _squares(name)
    every = {
        "NEES": (found.nees, STATES),
        "NIS of packets": (found.packets, PACKET),
        "NIS of contacts": (found.contacts, CONTACT),
    }
    return {
        word: (float(np.nanmean(values)), share_inside(values, size))
        for word, (values, size) in every.items()
        if np.isfinite(values).any()
    }


def _means(name: str) -> list[tuple[float, int]]:
    """Return the mean of NEES and of NIS for packets and for contacts, each with its expected value."""
    found = _squares(name)
    every = ((found.nees, STATES), (found.packets, PACKET), (found.contacts, CONTACT))
    return [(float(np.nanmean(values)), size) for values, size in every if np.isfinite(values).any()]


def _rows(_runs: list[Run]) -> list[Row]:
    rows = []
    for name in _SETTINGS:
        words = [
            f"{word} {mean:.2f}, inside at {100.0 * share:.0f} % of the instants"
            for word, (mean, share) in _shares(name).items()
        ]
        rows.append(Row(name, "NEES 6, NIS 6 and 3; inside at 95 %", "; ".join(words), NO_NUMBER))
    return rows


def synthetic_errors_m(slot_s: float, loss_prob: float) -> tuple[float, float, float]:
    """
    Return the rms position errors (m) of filter, last packet held and dead reckoning on the filter's model.

    Four vehicles have one slot each, so a packet arrives every four slots; exact navigation, six runs of 200
    s.
    """
    setting = Setting(packets_every_s=_VEHICLES * slot_s, loss_prob=loss_prob)
    squares_m2 = []
    for seed in np.random.SeedSequence(_SEED).spawn(_ERROR_RUNS):
        table, last = NeighbourTable(_CONFIG), None
        for tick, now in enumerate(fly(setting, _CONFIG, np.random.default_rng(seed), _ERROR_S)):
            for report in now.reports:
                table.receive(report)
                last = _newer(last, report)
            if tick % 5 == 0 and last is not None:
                for estimate in table.estimates(now.t_s):
                    held = np.array(last.position) - now.truth[:3]
                    reckoned = held + estimate.age_s * np.array(last.velocity)
                    error = np.array(estimate.position) - now.truth[:3]
                    squares_m2.append((error @ error, held @ held, reckoned @ reckoned))
    ekf_m, hold_m, reckoned_m = np.sqrt(np.mean(squares_m2, axis=0)).tolist()
    return ekf_m, hold_m, reckoned_m


def _newer(last: Report | None, report: Report) -> Report:
    return report if last is None or report.time_s > last.time_s else last


def _error_rows(_runs: list[Run]) -> list[Row]:
    rows = []
    for loss in LOSSES:
        for slot_s in SLOTS_S:
            ekf_m, hold_m, reckoned_m = synthetic_errors_m(slot_s, loss)
            rows.append(
                Row(
                    f"slots of {slot_s:g} s, {100.0 * loss:.0f} % lost",
                    "not given",
                    f"filter {ekf_m:.3f} m, last packet held {hold_m:.3f} m, dead reckoned "
                    f"{reckoned_m:.3f} m; filter / held {ekf_m / hold_m:.2f}",
                    NO_NUMBER,
                )
            )
    return rows


def _draw(canvas: Canvas, _runs: list[Run]) -> None:
    panels = canvas.subplots(1, 2)
    low, high = band(STATES, _RUNS)
    for index, name in enumerate(_SETTINGS):
        found = _squares(name)
        panels[0].plot(found.t_s, np.nanmean(found.nees, axis=0), label=name, **vehicle_style(index))
        if np.isfinite(found.contacts).any():
            rows = np.isfinite(found.contacts).sum(axis=0) > 0.5 * _RUNS
            mean = np.nanmean(found.contacts[:, rows], axis=0)
            panels[1].plot(np.arange(1, len(mean) + 1), mean, **vehicle_style(index))
    for axes, (bottom, top) in zip(panels, ((low, high), band(CONTACT, _RUNS)), strict=True):
        axes.axhspan(bottom, top, color="0.85", zorder=0)
    panels[0].set_xlabel("t (s)")
    panels[0].set_ylabel("mean NEES of 100 runs (6 numbers)")
    panels[1].set_xlabel("contact of a run")
    panels[1].set_ylabel("mean NIS of contacts (3 numbers)")
    handles, labels = panels[0].get_legend_handles_labels()
    legend_below(canvas, handles, labels, columns=2)


def _judge(_runs: list[Run]) -> Verdict:
    shares = [share for name in _OWN_MODEL for _, share in _shares(name).values()]
    means = [mean / size for name in _OWN_MODEL for mean, size in _means(name)]
    low, high = band(STATES, _RUNS)
    evidence = (
        f"{_RUNS} runs, interval of the mean NEES [{low:.2f}, {high:.2f}]: NEES and NIS of {len(_OWN_MODEL)} "
        f"settings inside their intervals at {100.0 * np.mean(shares):.0f} % of the instants, "
        f"{100.0 * min(shares):.0f} % in the worst; means over all instants "
        f"between {min(means):.3f} and {max(means):.3f} of the expected value"
    )
    is_close = max(abs(mean - 1.0) for mean in means) < 0.05
    return Verdict(
        HOLDS if np.mean(shares) >= 0.9 and is_close else HOLDS_IN_PART if is_close else DOES_NOT_HOLD,
        evidence,
    )


FIGURES = (
    Figure(
        "A.32",
        "Consistency of the neighbour filter: NEES and NIS of 100 runs",
        (),
        _draw,
        "No counterpart in the thesis. Grey: 95 % interval of a consistent filter. The truth follows the "
        "filter's own model; navigations drift at a constant random rate.",
    ),
)

TABLES = (
    Table("A.32", "Consistency of the neighbour filter, 100 runs per setting", (), _rows, "consistent"),
    Table("A.35", "Error of a neighbour's position on the filter's own model", (), _error_rows),
)

CLAIMS = (
    Claim(
        "A.34",
        "On truth that follows the filter's own model, NEES and NIS lie within their 95 % intervals at nine "
        "of ten instants (ours).",
        (),
        _judge,
    ),
)
