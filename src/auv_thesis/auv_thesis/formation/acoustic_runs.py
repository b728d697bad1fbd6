"""
Runs of formations over acoustic links, by reference type, slot and loss, and of one repair with many seeds.

A cell flies one run for every `EVERY` seeds that are asked for. Cells of `FIRST_LOOK` fly their first run
always, the others only if more than `FIRST_LOOK_SEEDS` are asked for.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from auv_thesis.items import RunSpec

N_SEEDS = 100
EVERY = 25
FIRST_LOOK_SEEDS = 2
FIRST_LOOK = (0.5, 0.3)
"""Slot (s) and share of losses of the cells of the first look."""
FIRST_REPAIR_SEED = 70_001

SLOTS_S = (0.5, 2.0, 8.0)
LOSSES = (0.0, 0.3, 0.6)
REFERENCES = {
    "leader": (1.0, 0.0, 0.0),
    "predecessor": (0.0, 1.0, 0.0),
    "l-p 0.5/0.5": (0.5, 0.5, 0.0),
    "neighbour": (0.0, 0.0, 1.0),
}
CYCLES_TO_HEAR = 8.0
"""The fleet stays at rest for so many cycles, and a vehicle counts as lost after as many without news."""
SETTLING_S = 120.0
"""From the departure to a step of the speed, a switch or a loss."""
_SHARES = ("leader_share", "predecessor_share", "neighbour_share")


Specs = tuple[RunSpec, ...]


class Cell(NamedTuple):
    """A case, the length of a slot (s) and the share of packets that is lost."""

    case: str
    slot_s: float
    loss_prob: float


def _wait_s(cell: Cell, vehicles: int) -> float:
    """Return the time at rest, and that without news after which a vehicle is lost (s)."""
    return max(40.0, CYCLES_TO_HEAR * vehicles * cell.slot_s)


def _departure(cell: Cell, vehicles: int) -> str:
    return f"reference.params.from_s=[0.0, {_wait_s(cell, vehicles)}]"


def _specs(scenario: str, cell: Cell, vehicles: int, duration_s: float, *changes: str) -> Specs:
    wait_s = _wait_s(cell, vehicles)
    first = 0 if (cell.slot_s, cell.loss_prob) == FIRST_LOOK else FIRST_LOOK_SEEDS
    return tuple(
        RunSpec(
            scenario,
            (
                f"seed={1 + index}",
                f"acoustics.mac.params.slot_s={cell.slot_s}",
                f"acoustics.outage.params.loss_prob={cell.loss_prob}",
                f"agent.flocking.params.lost_after_s={wait_s}",
                *changes,
            ),
            duration_s,
            keep_recording=False,
            nth=first + EVERY * index,
        )
        for index in range(N_SEEDS // EVERY)
    )


@cache
def string_runs() -> dict[Cell, Specs]:
    """Return the runs of a column of eight from rest, by cell."""
    runs = {}
    for name, shares in REFERENCES.items():
        changes = [f"agent.flocking.params.{key}={value}" for key, value in zip(_SHARES, shares, strict=True)]
        for slot_s in SLOTS_S:
            for loss_prob in LOSSES:
                cell = Cell(name, slot_s, loss_prob)
                at_s = _wait_s(cell, 8) + SETTLING_S
                times = f"reference.params.from_s=[0.0, {_wait_s(cell, 8)}, {at_s}]"
                runs[cell] = _specs("formation_string", cell, 8, 2.0 * at_s, *changes, times)
    return runs


@cache
def switch_runs() -> dict[Cell, Specs]:
    """Return the runs of six vehicles that switch from a column to a line, by cell."""
    runs = {}
    for slot_s in SLOTS_S:
        for loss_prob in LOSSES:
            cell = Cell("column to line", slot_s, loss_prob)
            at_s = _wait_s(cell, 6) + SETTLING_S
            changes = (_departure(cell, 6), f"agent.flocking.params.switch_at_s={at_s}")
            runs[cell] = _specs("formation_switching", cell, 6, 2.0 * at_s + 80.0, *changes)
    return runs


@cache
def repair_runs() -> dict[Cell, Specs]:
    """Return the runs of eight vehicles that lose two, by cell."""
    runs = {}
    for slot_s in SLOTS_S:
        for loss_prob in LOSSES:
            cell = Cell("leader and one lost", slot_s, loss_prob)
            at_s = _wait_s(cell, 8) + SETTLING_S
            changes = [_departure(cell, 8), *(f"vehicles.{index}.fails_at_s={at_s}" for index in (0, 3))]
            runs[cell] = _specs("formation_repair", cell, 8, at_s + 2.0 * _wait_s(cell, 8) + 120.0, *changes)
    return runs


REPAIRS = tuple(
    RunSpec("formation_repair", (f"seed={FIRST_REPAIR_SEED + index}",), keep_recording=False, nth=index)
    for index in range(N_SEEDS)
)
"""Eight vehicles of which the leader and a follower are lost at 100 s, one run for each seed."""
