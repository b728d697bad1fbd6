"""Silent nodes in real time, in which no tick waits for an answer."""

from __future__ import annotations

from collections.abc import Container
from itertools import product

ROLES = ("agent_node", "vehicle_node")


class Silences:
    """
    The last time each node of a fleet was heard; every `now_s` is a time of one steady clock (s).

    Vehicles are counted from 0; a node is its role, one of `ROLES`, and its vehicle.

    Parameters
    ----------
    count : int
        Number of vehicles.
    limit_s : float
        Silence after which a node is overdue (s).

    """

    def __init__(self, count: int, limit_s: float) -> None:
        self._nodes = list(product(ROLES, range(count)))
        self._limit_s = limit_s
        self._heard_at_s: dict[tuple[str, int], float] = {}

    def begin(self, now_s: float) -> None:
        """Start to count: no node is late when a run begins."""
        self._heard_at_s = dict.fromkeys(self._nodes, now_s)

    def hear(self, role: str, vehicle: int, now_s: float) -> None:
        """Note that a node was heard."""
        self._heard_at_s[role, vehicle] = now_s

    def silent(self, now_s: float, *, without: Container[int]) -> list[tuple[str, int]]:
        """Return the nodes that have been silent for too long, except those of some vehicles."""
        return [
            (role, vehicle)
            for (role, vehicle), heard_at_s in self._heard_at_s.items()
            if vehicle not in without and now_s - heard_at_s > self._limit_s
        ]
