"""
Whether a neighbour filter's errors are as large as it says: NEES and NIS over many runs.

The normalised estimation error squared is e' P^-1 e, with e the error and P its covariance; of a consistent
filter it is chi-square distributed with as many degrees of freedom as e has numbers. The normalised
innovation squared is the same of measurement minus prediction.  Over M runs their sum has M times as many.

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
    Normalised squares of many runs.

    `t_s` (K,): instants (s); `nees` (runs, K): of position and velocity; `packets`, `contacts` (runs, M): of
    the M-th innovation of a run. NaN where a run has none.
    """

    t_s: FloatArray
    nees: FloatArray
    packets: FloatArray
    contacts: FloatArray


def band(size: int, runs: int) -> tuple[float, float]:
    """Return the 95 % interval of the mean over so many runs of a square with so many numbers."""
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

    The truth follows the filter's own model, unless `truth` gives it other numbers.
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
    """Return in which share of the columns the mean over the runs lies in its 95 % interval."""
    inside = []
    for column in values.T:
        known = column[np.isfinite(column)]
        if len(known) > 0.5 * len(column):
            low, high = band(size, len(known))
            inside.append(low < known.mean() < high)
    return float(np.mean(inside)) if inside else float("nan")


class _Run:
    """One vehicle that hears and sees the only neighbour."""

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
