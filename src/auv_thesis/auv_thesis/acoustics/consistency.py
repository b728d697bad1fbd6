"""
Consistency of a neighbour filter, that is whether its errors match its covariance: NEES and NIS over many
runs.

The normalised estimation error squared (NEES) is e' P^-1 e, with the error e and its covariance P. For a
consistent filter it has a chi-square distribution with as many degrees of freedom as e has elements. The
normalised innovation squared (NIS) is the same for measurement minus prediction. The sum over M runs has M
times as many degrees of freedom.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section
5.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_flocking.neighbours.synthetic_neighbour import Setting, fly
from auv_flocking.neighbours.table import NeighbourConfig, NeighbourTable

FloatArray = NDArray[np.float64]

STATES, PACKET, CONTACT = 6, 6, 3
_FROM_S = 5.0
_EVERY_TICKS = 10


@dataclass(frozen=True)
class Squares:
    """
    NEES and NIS of many runs.

    `t_s` (K,): instants (s); `nees` (runs, K): NEES of position and velocity; `packets`, `contacts` (runs,
    M): NIS of the M-th innovation of a run, NaN if a run has fewer.
    """

    t_s: FloatArray
    nees: FloatArray
    packets: FloatArray
    contacts: FloatArray


def band(size: int, runs: int) -> tuple[float, float]:
    """Return the 95 % interval of the mean, over `n_runs` runs, of a normalised square of `size` elements."""
    from scipy.stats import chi2

    low, high = chi2.interval(0.95, size * runs)
    return float(low) / runs, float(high) / runs


def squares(
    setting: Setting,
    config: NeighbourConfig,
    seeds: Sequence[np.random.SeedSequence],
    duration_s: float,
    truth: NeighbourConfig | None = None,
) -> Squares:
    """
    Fly one run per seed and normalise the errors.

    The truth follows the filter's own model, unless `truth` gives other parameters.
    """
    nees, packets, contacts, t_s = [], [], [], []
    for seed in seeds:
        run = _Run(NeighbourTable(config))
        t_s = run.follow(setting, truth or config, np.random.default_rng(seed), duration_s)
        nees.append(run.nees)
        packets.append(run.packets)
        contacts.append(run.contacts)
    return Squares(np.array(t_s), np.array(nees), _padded(packets), _padded(contacts))


def share_inside(values: FloatArray, size: int) -> float:
    """Return the share of the columns in which the mean over the runs lies within its 95 % interval."""
    inside = []
    for column in values.T:
        known = column[np.isfinite(column)]
        if len(known) > 0.5 * len(column):
            low, high = band(size, len(known))
            inside.append(low < known.mean() < high)
    return float(np.mean(inside)) if inside else float("nan")


class _Run:
    """One vehicle that hears its only neighbour and sees it with sonar."""

    def __init__(self, table: NeighbourTable) -> None:
        self._table = table
        self.nees: list[float] = []
        self.packets: list[float] = []
        self.contacts: list[float] = []

    def follow(
        self, setting: Setting, config: NeighbourConfig, rng: np.random.Generator, duration_s: float
    ) -> list[float]:
        """Fly one run; return the instants of `nees` (s)."""
        table, t_s = self._table, []
        for tick, now in enumerate(fly(setting, config, rng, duration_s)):
            for report in now.reports:
                table.receive(report)
                self.packets.append(table.tracks[0].nis(report.time_s, PACKET))
            used = table.contacts_used
            table.observe(now.t_s, now.nav, now.contacts)
            if table.contacts_used > used:
                self.contacts.append(table.tracks[0].nis(now.t_s, CONTACT))
            estimates = table.estimates(now.t_s, now.nav)
            if now.t_s > _FROM_S and tick % _EVERY_TICKS == 0:
                t_s.append(now.t_s)
                self.nees.append(np.nan)
                for estimate in estimates:
                    error = np.array((*estimate.position, *estimate.velocity)) - now.truth
                    self.nees[-1] = float(error @ np.linalg.solve(estimate.covariance, error))
        return t_s


def _padded(rows: list[list[float]]) -> FloatArray:
    padded = np.full((len(rows), max(map(len, rows), default=0)), np.nan)
    for padded_row, row in zip(padded, rows, strict=True):
        padded_row[: len(row)] = row
    return padded
