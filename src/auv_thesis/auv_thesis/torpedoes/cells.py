"""
Cells of the study of torpedoes: one case each, flown with many seeds, and the limits that it must keep.

All cells have the same seeds, of which none was used to choose a part of the law. The seed gives starts,
headings and losses. Current, lost vehicle and time of the loss follow the number of the seed by even steps of
an irrational share, which fill their ranges evenly.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from auv_thesis.acoustics.safety_runs import chosen
from auv_thesis.items import Run, RunSpec
from auv_thesis.torpedoes.limits import Limit

FIRST_SEED = 90_001
N_SEEDS = 50
FIRST_LOOK_SEEDS = 2
CURRENT_MPS = 0.3
_GOLDEN_SHARE = 0.618033988749895
_PLASTIC_SHARE = 0.754877666246693
_PERIOD_S = 0.2

SeedChanges = Callable[[int], tuple[str, ...]]


@dataclass(frozen=True)
class Cell:
    """
    One case.

    Attributes
    ----------
    name : str
        In words.
    scenario : str
        The scenario.
    changes : tuple of str
        Its overrides, the same for all seeds.
    limits : tuple of Limit
        What its runs must keep.
    duration_s : float, optional
        Length of a run (s), by default that of the scenario.
    per_seed : function, optional
        From the number of a seed, from 0, to further overrides.
    every : int
        The cell flies a seed of so many that are asked for.
    is_first_look : bool
        Whether it flies the first seeds even if few are asked for.

    """

    name: str
    scenario: str
    changes: tuple[str, ...]
    limits: tuple[Limit, ...]
    duration_s: float | None = None
    per_seed: SeedChanges | None = None
    every: int = 1
    is_first_look: bool = False

    def __str__(self) -> str:
        """Return the name."""
        return self.name

    @property
    def specs(self) -> tuple[RunSpec, ...]:
        """The runs, in the order of the seeds."""
        first = 0 if self.is_first_look else FIRST_LOOK_SEEDS
        return tuple(
            RunSpec(
                self.scenario,
                (f"seed={FIRST_SEED + index}", *self.changes, *(self.per_seed or in_a_current)(index)),
                self.duration_s,
                keep_recording=False,
                nth=max(index * self.every, first),
            )
            for index in range(-(-N_SEEDS // self.every))
        )

    def runs_among(self, runs: list[Run]) -> list[Run]:
        """Return those runs that are of this cell."""
        return chosen(runs, self.specs)


def _share(index: int, step: float) -> float:
    return math.fmod((index + 1) * step, 1.0)


def in_a_current(index: int) -> tuple[str, ...]:
    """Return the current of a seed, whose direction is any."""
    direction_rad = math.tau * _share(index, _GOLDEN_SHARE)
    north_mps, east_mps = CURRENT_MPS * math.cos(direction_rad), CURRENT_MPS * math.sin(direction_rad)
    return (f"environment.current_ned_mps=[{north_mps:.4f}, {east_mps:.4f}, 0.0]",)


def in_still_water(index: int) -> tuple[str, ...]:
    """Return no further overrides."""
    del index
    return ()


def losing_one(count: int, first_s: float, last_s: float) -> SeedChanges:
    """Return, for a fleet of a size, the loss of one vehicle in an interval of time (s), and the current."""

    def of_seed(index: int) -> tuple[str, ...]:
        at_s = first_s + (last_s - first_s) * _share(index, _PLASTIC_SHARE)
        at_s = round(at_s / _PERIOD_S) * _PERIOD_S
        lost = index % count
        vehicles = ", ".join(
            "{"
            f"id: auv_{i + 1}, model: {{preset: remus100}}, speed_mps: 1.5"
            f"{f', fails_at_s: {at_s:.1f}' if i == lost else ''}"
            "}"
            for i in range(count)
        )
        return (f"vehicles=[{vehicles}]", *in_a_current(index))

    return of_seed
