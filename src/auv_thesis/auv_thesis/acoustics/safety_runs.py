"""
Runs of the safety study: the scenario `flock_modem` over slots, losses, navigations, laws and fleets.

Seeds are 3001, 3002, ..., and 4001, 4002, ... if navigations drift: runs with 3001-3100 showed that the
stated navigation error must count more. No part of the law was chosen from a run with a seed of its own
study. Cells with limits fly all seeds that `--seeds` asks for; the others fly the first fifth, tenth or
twenty-fifth of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from auv_experiment.confidence.binomial import share_words
from auv_experiment.confidence.clusters import NO_INTERVAL, Interval, percentile_interval
from auv_thesis.items import Run, RunSpec

FIRST_SEED = 3001
FIRST_DRIFTING_SEED = 4001
N_SEEDS = 100
HULLS_TOUCH_M = 0.62
FAR_M = 10.0

Cell = tuple[float, float]
CELLS: tuple[Cell, ...] = ((0.5, 0.0), (0.5, 0.3), (0.5, 0.6), (2.0, 0.0), (2.0, 0.3), (2.0, 0.6))
GENTLE, USUAL, WORST = CELLS[0], CELLS[1], CELLS[-1]

THESIS_LAW = (
    "agent.flocking={kind: potential, params: {followers: blind}}",
    "agent.consensus={kind: thesis, params: {carried_by: flock}}",  # extrapolated by rate, it diverges
)
_DRIFT = "environment.navigation={kind: dead_reckoning}"
_FIXES = "environment.navigation={kind: dead_reckoning, params: {fix: lbl, fix_period_s: 60.0}}"
_SONAR = "acoustics.sonar={kind: active}"
DRIFT_SONAR, DRIFT_FIXES = "drift, sonar", "drift, a fix every 60 s"
NAVIGATIONS = {
    DRIFT_SONAR: (_DRIFT, _SONAR),
    DRIFT_FIXES: (_FIXES,),
    "drift, both": (_FIXES, _SONAR),
    "drift alone": (_DRIFT,),
    "exact, sonar": (_SONAR,),
}
_LAW = "agent.flocking.params"
PARTS = {
    "without matching the gains to the age": (f"{_LAW}.lag_budget_rad=1.0e+9",),
    "without the barrier": (f"{_LAW}.barrier=false",),
    "without both of these": (f"{_LAW}.lag_budget_rad=1.0e+9", f"{_LAW}.barrier=false"),
    "without widening by uncertainty": (f"{_LAW}.spacing_sigmas=0.0", f"{_LAW}.barrier_sigmas=0.0"),
    "without the velocity in that uncertainty": (f"{_LAW}.closing_ratio=0.0",),
    "without a memory of the age": (f"{_LAW}.age_memory_s=0.2",),
    "without the bound on a correction's reach": (f"{_LAW}.reach_m=1.0e+9",),
    "mean flock velocity instead of the newest": (f"{_LAW}.relay=mean",),
    "without waiting for every neighbour": ("agent.hold_s=0.0",),
    "without gathering faster from afar": (f"{_LAW}.gathering_budget_rad=0.3",),
    "without layers of depth": (f"{_LAW}.layer_depth_m=null",),
}


@dataclass(frozen=True)
class Bars:
    """
    Limits of a cell: distances at any time, once formed, and late (m), and the path error (m) if it has one.
    """

    ever_m: float
    formed_m: float
    path_m: float | None = None
    share_near: float = 1.0

    def __str__(self) -> str:
        """Return the limits as text for a table."""
        late = f"at most {FAR_M:g} m" + (
            "" if self.share_near == 1.0 else f" in {100.0 * self.share_near:.0f} %"
        )
        path = "" if self.path_m is None else f", path {self.path_m:g} m"
        return f"{self.ever_m:g} m, {self.formed_m:g} m, {late}{path}"


BARS = {
    (0.5, 0.0): Bars(1.0, 1.4),
    (0.5, 0.3): Bars(1.0, 1.4, 0.1),
    (0.5, 0.6): Bars(1.0, 1.4),
    (2.0, 0.0): Bars(1.0, 1.4),
    (2.0, 0.3): Bars(1.0, 1.4, 0.35),
    (2.0, 0.6): Bars(0.6, 1.2, 0.8, share_near=0.97),
}
SONAR_BARS = {cell: replace(bars, path_m=None) for cell, bars in BARS.items()}
FIXES_BARS = {
    cell: Bars(0.6, 0.9, 0.8 if cell == USUAL else None, bars.share_near) for cell, bars in BARS.items()
}


def name_of(cell: Cell) -> str:
    """Return a cell as text."""
    return f"slots of {cell[0]:g} s, {100.0 * cell[1]:.0f} % lost"


def study(
    cell: Cell, changes: Sequence[str] = (), *, every: int = 1, first_seed: int = FIRST_SEED
) -> tuple[RunSpec, ...]:
    """Return the runs of one cell, for every `every`-th of the requested seeds."""
    slot_s, loss_prob = cell
    return tuple(
        RunSpec(
            "flock_modem",
            (
                f"seed={first_seed + index}",
                f"acoustics.mac.params.slot_s={slot_s}",
                f"acoustics.outage.params.loss_prob={loss_prob}",
                *changes,
            ),
            keep_recording=False,
            nth=every * index,
        )
        for index in range(N_SEEDS // every)
    )


def fleet(n_vehicles: int) -> tuple[str, ...]:
    """
    Return the overrides for another number of vehicles at the same initial density, in layers as far apart
    as those of twelve.
    """
    vehicles = ", ".join(f"{{id: auv_{k}, model: {{preset: odin}}}}" for k in range(1, n_vehicles + 1))
    radius_m = round(10.0 * (n_vehicles / 4) ** (1 / 3), 1)
    span_m = round(max(7.5, 0.68 * (n_vehicles - 1)), 1)
    return (
        f"vehicles=[{vehicles}]",
        f"random_starts.radius_m={radius_m}",
        f"{_LAW}.layer_span_m={span_m}",
    )


OURS = {cell: study(cell) for cell in CELLS}
THESIS = {cell: study(cell, THESIS_LAW) for cell in CELLS}
WITH_SONAR, WITH_FIXES = (
    {cell: study(cell, NAVIGATIONS[name], first_seed=FIRST_DRIFTING_SEED) for cell in CELLS}
    for name in (DRIFT_SONAR, DRIFT_FIXES)
)
OTHERWISE_NAVIGATED = {
    name: study(USUAL, changes, every=10, first_seed=FIRST_DRIFTING_SEED)
    for name, changes in NAVIGATIONS.items()
    if name not in (DRIFT_SONAR, DRIFT_FIXES)
}
ABLATED = {
    (cell, part): study(cell, changes, every=5) for cell in (USUAL, WORST) for part, changes in PARTS.items()
}
FLEETS = {
    (8, USUAL): study(USUAL, fleet(8), every=10),
    (8, (2.0, 0.3)): study((2.0, 0.3), fleet(8), every=10),
    (16, USUAL): study(USUAL, fleet(16), every=25),
}


@dataclass(frozen=True)
class Summary:
    """Summary of the runs of one case: distances of pairs and path error over all runs."""

    n: int
    ever_m: float
    formed_m: float
    late_m: float
    path_p95_m: float
    path_p95_interval: Interval
    n_touching: int
    n_far: int
    n_never_formed: int

    def __str__(self) -> str:
        """Return it as text for a table, in the order of `Bars`."""
        low, high = (
            "–" if bound is None else f"{bound:.2f}"
            for bound in (self.path_p95_interval.low, self.path_p95_interval.high)
        )
        path = f"{self.path_p95_m:.2f} m" if np.isfinite(self.path_p95_m) else "never reached"
        distances = f"{self.ever_m:.2f} m, {self.formed_m:.2f} m, {self.late_m:.1f} m"
        return f"{distances}, path {path} [{low}, {high}]"

    @property
    def remark(self) -> str:
        """Return how many of the runs went badly, with the exact bounds of these shares."""
        words = [
            f"hulls touch in {share_words(self.n_touching, self.n)}",
            f"over {FAR_M:g} m in {share_words(self.n_far, self.n)}",
        ]
        if self.n_never_formed:
            words.append(f"never formed in {share_words(self.n_never_formed, self.n)}")
        return ", ".join(words)

    def keeps(self, bars: Bars) -> bool:
        """Return whether the runs keep the limits."""
        near = self.n_far <= (1.0 - bars.share_near) * self.n + 1e-9
        on_path = bars.path_m is None or self.path_p95_m <= bars.path_m
        return self.ever_m >= bars.ever_m and self.formed_m >= bars.formed_m and near and on_path


def summary_of(runs: Sequence[Run]) -> Summary:
    """
    Return the summary of the runs, of which there must be at least one.

    A flock that never formed has no path error, and counts as infinitely far from its path.
    """
    ever_m, formed_m, late_m, path_m = (
        np.array([run.metrics[key] for run in runs], dtype=np.float64)
        for key in (
            "pair_distance_min_m",
            "pair_distance_min_after_150s_m",
            "pair_distance_max_after_200s_m",
            "centroid_path_formed_rms_m",
        )
    )
    has_formed = np.isfinite(path_m)
    path_m = np.where(has_formed, path_m, np.inf)
    return Summary(
        len(runs),
        float(ever_m.min()),
        float(formed_m.min()),
        float(late_m.max()),
        float(np.quantile(path_m, 0.95, method="higher")),
        percentile_interval(path_m, 0.95) if has_formed.all() else NO_INTERVAL,
        int((ever_m < HULLS_TOUCH_M).sum()),
        int((late_m > FAR_M).sum()),
        int((~has_formed).sum()),
    )


def chosen(runs: Sequence[Run], specs: Sequence[RunSpec]) -> list[Run]:
    """Return the runs that belong to a study."""
    wanted = set(specs)
    return [run for run in runs if run.spec in wanted]
