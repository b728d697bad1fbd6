"""Runs of formations over acoustic links, by reference type, slot and loss."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from auv_thesis.items import RunSpec

SLOTS_S = (0.5, 2.0, 8.0)
LOSSES = (0.0, 0.3, 0.6)
REFERENCES = {
    "leader": (1.0, 0.0, 0.0),
    "predecessor": (0.0, 1.0, 0.0),
    "l-p 0.5/0.5": (0.5, 0.5, 0.0),
    "neighbour": (0.0, 0.0, 1.0),
}
CYCLES_OF_SILENCE = 8.0
"""A vehicle counts as lost after this many cycles without news."""
_SHARES = ("leader_share", "predecessor_share", "neighbour_share")


class Cell(NamedTuple):
    """A case, the length of a slot (s) and the share of packets that is lost."""

    case: str
    slot_s: float
    loss_prob: float


def _spec(scenario: str, cell: Cell, vehicles: int, duration_s: float, *changes: str) -> RunSpec:
    lost_after_s = max(30.0, CYCLES_OF_SILENCE * vehicles * cell.slot_s)
    return RunSpec(
        scenario,
        (
            f"acoustics.mac.params.slot_s={cell.slot_s}",
            f"acoustics.outage.params.loss_prob={cell.loss_prob}",
            f"agent.flocking.params.lost_after_s={lost_after_s}",
            *changes,
        ),
        duration_s,
    )


@cache
def string_runs() -> dict[Cell, RunSpec]:
    """Return the runs of a column of eight from rest, by cell."""
    runs = {}
    for name, shares in REFERENCES.items():
        changes = [f"agent.flocking.params.{key}={value}" for key, value in zip(_SHARES, shares, strict=True)]
        for slot_s in SLOTS_S:
            for loss_prob in LOSSES:
                cell = Cell(name, slot_s, loss_prob)
                runs[cell] = _spec("formation_string", cell, 8, 240.0 if slot_s < 8.0 else 800.0, *changes)
    return runs


@cache
def switch_runs() -> dict[Cell, RunSpec]:
    """Return the runs of six vehicles that switch from a column to a line at 90 s, by cell."""
    cells = [Cell("column to line", slot_s, loss_prob) for slot_s in SLOTS_S for loss_prob in LOSSES]
    return {
        cell: _spec("formation_switching", cell, 6, 240.0 if cell.slot_s < 8.0 else 600.0) for cell in cells
    }


@cache
def repair_runs() -> dict[Cell, RunSpec]:
    """Return the runs of eight vehicles that lose two at 60 s, by cell."""
    cells = [Cell("leader and one lost", slot_s, loss_prob) for slot_s in SLOTS_S for loss_prob in LOSSES]
    return {
        cell: _spec("formation_repair", cell, 8, 300.0 if cell.slot_s < 8.0 else 1000.0) for cell in cells
    }
