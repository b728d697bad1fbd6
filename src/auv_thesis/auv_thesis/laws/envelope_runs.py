"""
Runs of the safety envelope: `flock_modem` over fleets, cycles, bursts of losses, starts and currents.

A cell flies one case with many seeds. All cells have the same seeds, of which none was used to choose a part
of the law or of the filter. A first look flies the cells of `FIRST_LOOK` only.

Bursts are those of a chain of two states per link that steps once per packet, and so once per cycle of N
slots. Links are bad for half of the time. A bad state lasts 1 / p packets on average, p being the chance to
leave it. A chain that is bad for half of the time and would rather stay than change has p of at most 1 / 2:
no mean is shorter than two cycles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from auv_experiment.confidence.binomial import exact_upper_bound, share_words
from auv_experiment.metrics.windows import LATE_AFTER_S
from auv_thesis.acoustics.safety_runs import FAR_M, HULLS_TOUCH_M, fleet
from auv_thesis.items import Run, RunSpec

FIRST_SEED = 70_001
N_SEEDS = 100
FIRST_LOOK_SEEDS = 2
NEAR_M = 1.0
SAFE_SHARE = 0.05
"""A cell is safe if the exact bound of the share of runs with contact is at most this."""
APART_SHARE = 0.05
"""A flock stays together if at most this share of its runs comes apart."""

FLEETS = (4, 8, 12)
SLOTS_S = (0.5, 2.0)
BURSTS_S = (20.0, 160.0)
LOSS_PROB = 0.3
WIDE_M = 40.0
_MOST_CHANGE_PROB = 0.5
_VARYING = "{kind: gauss_markov, params: {sd_ned_mps: [0.05, 0.05, 0.02], memory_s: 60.0, common_share: 0.5}}"


@dataclass(frozen=True)
class Cell:
    """
    One case of the envelope.

    Attributes
    ----------
    n_vehicles : int
        Number of vehicles.
    slot_s : float
        Length of a slot (s); a cycle has one for each vehicle.
    wanted_burst_s : float, optional
        Mean time that a link stays bad (s), at least two cycles; without it losses are independent.
    start_radius_m : float, optional
        Radius of the ball of the starts (m), by default that of four vehicles in 10 m at the same density.
    is_current_varying : bool
        Whether the current varies about its mean, partly alike at all vehicles and partly not.
    starts_in_order : bool
        Whether the starts are in the order of the layers, so that vehicles need not pass each other.
    runs_per_seed : int
        Number of runs for every seed that is asked for.

    """

    n_vehicles: int
    slot_s: float
    wanted_burst_s: float | None = None
    start_radius_m: float | None = None
    is_current_varying: bool = False
    starts_in_order: bool = True
    runs_per_seed: int = 1

    def __str__(self) -> str:
        """Return the cell as text."""
        losses = (
            f"{100.0 * LOSS_PROB:.0f} % lost" if self.burst_s is None else f"bursts of {self.burst_s:.0f} s"
        )
        words = [f"{self.n_vehicles} vehicles", f"slots of {self.slot_s:g} s", losses]
        if self.start_radius_m is not None:
            words.append(f"starts within {self.start_radius_m:g} m")
        if self.is_current_varying:
            words.append("current that varies")
        if not self.starts_in_order:
            words.append("starts in any order")
        return ", ".join(words)

    @property
    def cycle_s(self) -> float:
        """Time between two packets of a vehicle (s)."""
        return self.n_vehicles * self.slot_s

    @property
    def change_prob(self) -> float | None:
        """Probability that the state of a link is another one at the next packet; None without bursts."""
        if self.wanted_burst_s is None:
            return None
        return min(self.cycle_s / self.wanted_burst_s, _MOST_CHANGE_PROB)

    @property
    def burst_s(self) -> float | None:
        """Mean time that a link stays bad (s); None without bursts."""
        return None if self.change_prob is None else self.cycle_s / self.change_prob

    @property
    def may_form_late(self) -> bool:
        """Whether the flock is not expected to have formed within 200 s."""
        return self.wanted_burst_s is not None or self.start_radius_m is not None

    @property
    def changes(self) -> tuple[str, ...]:
        """The overrides of `flock_modem`, but for the seed."""
        outage = f"{{kind: bernoulli, params: {{loss_prob: {LOSS_PROB}}}}}"
        if self.change_prob is not None:
            chain = f"p_gb: {self.change_prob:.9g}, p_bg: {self.change_prob:.9g}"
            outage = (
                f"{{kind: gilbert_elliott, params: {{{chain}, loss_good_prob: 0.02, loss_bad_prob: 0.98}}}}"
            )
        words = [f"acoustics.mac.params.slot_s={self.slot_s}", f"acoustics.outage={outage}"]
        words += fleet(self.n_vehicles)
        if self.start_radius_m is not None:
            words.append(f"random_starts.radius_m={self.start_radius_m}")
        if self.is_current_varying:
            words.append(f"environment.current={_VARYING}")
        if not self.starts_in_order:
            words.append("random_starts.in_depth_order=false")
        return tuple(words)


WORST = Cell(4, 2.0, 160.0, runs_per_seed=3)
"""The cell in which hulls touched before: it flies three times as many runs."""
FIRST_LOOK = (Cell(4, 0.5), Cell(4, 2.0), WORST)
CELLS = (
    *(
        WORST if (n_vehicles, slot_s, burst_s) == (4, 2.0, 160.0) else Cell(n_vehicles, slot_s, burst_s)
        for burst_s in (None, *BURSTS_S)
        for n_vehicles in FLEETS
        for slot_s in SLOTS_S
    ),
    Cell(4, 2.0, start_radius_m=WIDE_M),
    *(Cell(4, slot_s, is_current_varying=True) for slot_s in SLOTS_S),
    Cell(4, 2.0, 160.0, starts_in_order=False, runs_per_seed=3),
)


def _study(cell: Cell) -> tuple[RunSpec, ...]:
    """Return the runs of one cell; a first look leaves out those of most cells."""
    first = 0 if cell in FIRST_LOOK else FIRST_LOOK_SEEDS
    return tuple(
        RunSpec(
            "flock_modem",
            (f"seed={FIRST_SEED + index}", *cell.changes),
            keep_recording=False,
            nth=max(index // cell.runs_per_seed, first),
        )
        for index in range(N_SEEDS * cell.runs_per_seed)
    )


STUDY = {cell: _study(cell) for cell in CELLS}


def seed_of(run: Run) -> str:
    """Return the seed of a run, with which all cells of one fleet have the same starts."""
    return run.spec.overrides[0]


@dataclass(frozen=True)
class Summary:
    """
    Summary of the runs of one cell: counts of runs, and the nearest that hulls came (m).

    `n_late_far` counts flocks wider than 10 m after 200 s, `n_formed_far` those that became so wide after
    they had formed. A flock that never formed is apart, too, where it may form late.
    """

    n: int
    n_touching: int
    n_near: int
    n_late_far: int
    n_formed_far: int
    n_late_formed: int
    n_never_formed: int
    nearest_m: float
    nearest_p05_m: float
    may_form_late: bool

    @property
    def n_apart(self) -> int:
        """Number of runs whose flock did not stay together."""
        return self.n_formed_far + self.n_never_formed if self.may_form_late else self.n_late_far

    @property
    def touch_bound(self) -> float:
        """The exact 95 % upper bound of the share of runs with contact."""
        return exact_upper_bound(self.n_touching, self.n)

    @property
    def is_kept(self) -> bool:
        """Whether no run broke a limit, and at most the allowed share came apart."""
        return not self.n_near and self.n_apart <= APART_SHARE * self.n + 1e-9

    def __str__(self) -> str:
        """Return the distances as text for a table."""
        return f"{self.nearest_m:.2f} m, {self.nearest_p05_m:.2f} m"

    @property
    def shares(self) -> str:
        """Return the counts with the exact bounds of their shares."""
        return "; ".join(
            f"{words} in {share_words(count, self.n)}"
            for words, count in (
                ("hulls touch", self.n_touching),
                (f"nearer than {NEAR_M:g} m", self.n_near),
                (f"over {FAR_M:g} m after {LATE_AFTER_S:g} s", self.n_late_far),
                (f"over {FAR_M:g} m once formed", self.n_formed_far),
                (f"formed after {LATE_AFTER_S:g} s", self.n_late_formed),
                ("never formed", self.n_never_formed),
            )
        )


def summary_of(cell: Cell, runs: Sequence[Run]) -> Summary:
    """Return the summary of the runs of a cell, of which there must be at least one."""
    nearest_m, late_m, formed_m, formed_at_s = (
        np.array([run.metrics[key] for run in runs], dtype=np.float64)
        for key in (
            "pair_distance_min_m",
            "pair_distance_max_after_200s_m",
            "pair_distance_formed_max_m",
            "formed_at_s",
        )
    )
    return Summary(
        n=len(runs),
        n_touching=int((nearest_m < HULLS_TOUCH_M).sum()),
        n_near=int((nearest_m < NEAR_M).sum()),
        n_late_far=int((late_m > FAR_M).sum()),
        n_formed_far=int((formed_m > FAR_M).sum()),
        n_late_formed=int((formed_at_s > LATE_AFTER_S).sum()),
        n_never_formed=int((~np.isfinite(formed_at_s)).sum()),
        nearest_m=float(nearest_m.min()),
        nearest_p05_m=float(np.quantile(nearest_m, 0.05, method="lower")),
        may_form_late=cell.may_form_late,
    )
