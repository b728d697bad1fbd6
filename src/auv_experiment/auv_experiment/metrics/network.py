"""
The communication graph of a run, from the packets that were actually delivered.

At an instant, i hears j (the edge j -> i, a_ij = 1) if the newest packet of j that i has received was sent
within a time window. The graph is directed and changes; it is evaluated once per second, over the vehicles
that are not lost. It makes no assumptions about expected packets, so a vehicle out of range, or a flock in
two halves, becomes visible.

Algebraic connectivity is lambda_2 of the mirror graph, with weights (a_ij + a_ji) / 2: Olfati-Saber & Murray
("Consensus problems in networks of agents with switching topology and time-delays", IEEE TAC 2004) show that
on balanced graphs it bounds the rate of consensus. For other graphs it is only a measure: it is zero if and
only if the flock consists of parts that do not hear each other in either direction. Strong connectivity tells
whether information from every vehicle reaches every other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from auv_experiment.recording import BoolArray, FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


WINDOW_S = 30.0
"""Age up to which a packet counts as heard."""
EVERY_S = 1.0
_TOLERANCE_S = 1e-9


@dataclass(frozen=True, eq=False)
class Graphs:
    """
    The graph of a run at T instants, N vehicles.

    Attributes
    ----------
    t_s : (T,) array
        Scenario times (s).
    adjacency : (T, N, N) array of bool
        [k, i, j]: vehicle i hears vehicle j; false on the diagonal and for lost vehicles.
    alive : (T, N) array of bool
        Whether a vehicle counts, that is not lost.

    """

    t_s: FloatArray
    adjacency: BoolArray
    alive: BoolArray


def network_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of a run's graph.

    Parameters
    ----------
    recording : Recording
        What happened.
    scenario : Scenario
        Its scenario: whether there are packets.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; empty for a single vehicle and in continuous time, which has no packets.
        The instants, one per second, with at least two vehicles left count; for connectivity, degrees and
        parts, those after `graph_connected_at_s`, or all if that is None. `graph_disconnected_at_s` is 0 if
        the graph was never connected, None if it stayed so.

    """
    if recording.n_vehicles < 2 or scenario.sampling == "continuous":
        return {}
    graphs = heard_graphs(recording)
    counted = graphs.alive.sum(axis=1) >= 2
    t_s, adjacency, alive = graphs.t_s[counted], graphs.adjacency[counted], graphs.alive[counted]
    if not t_s.size:
        return dict.fromkeys(_KEYS)
    parts = strong_parts(adjacency, alive)
    whole = parts == 1
    first = int(whole.argmax()) if whole.any() else None
    later = slice(first, None)
    broken = np.flatnonzero(~whole[later])
    lambda_2 = algebraic_connectivity(adjacency[later], alive[later])
    heard = np.where(alive[later], adjacency[later].sum(axis=2), -1)
    hearers = np.where(alive[later], adjacency[later].sum(axis=1), -1)
    living = alive[later]
    values = (
        WINDOW_S,
        None if first is None else float(t_s[first]),
        float(t_s[later][broken[0]]) if broken.size else None,
        float(whole.mean()),
        float(lambda_2.mean()),
        float(lambda_2.min()),
        float(heard[living].mean()),
        int(heard[living].min()),
        int(hearers[living].min()),
        int(parts[later].max()),
    )
    return dict(zip(_KEYS, values, strict=True))


_KEYS = (
    "graph_window_s",
    "graph_connected_at_s",
    "graph_disconnected_at_s",
    "graph_strongly_connected_ratio",
    "graph_algebraic_connectivity_mean",
    "graph_algebraic_connectivity_min",
    "graph_degree_mean",
    "graph_in_degree_min",
    "graph_out_degree_min",
    "graph_parts_max",
)


def heard_graphs(recording: Recording, *, window_s: float = WINDOW_S, every_s: float = EVERY_S) -> Graphs:
    """
    Return the communication graph, from the delivered packets.

    Parameters
    ----------
    recording : Recording
        What happened.
    window_s : float
        Age (since the start of its transmission) up to which a vehicle's newest packet counts.
    every_s : float
        Time between the instants.

    """
    n, end_s = recording.n_vehicles, float(recording.t_s[-1])
    t_s: FloatArray = every_s * np.arange(int(end_s / every_s + _TOLERANCE_S) + 1, dtype=np.float64)
    lost_at_s = np.where(np.isnan(recording.lost_at_s), np.inf, recording.lost_at_s)
    alive = t_s[:, np.newaxis] < lost_at_s
    adjacency = np.zeros((len(t_s), n, n), dtype=bool)
    tick, source, destination = recording.received[:, :3].T
    arrived_s = recording.t_s[np.clip(tick, 0, recording.n_ticks)]
    left_s = arrived_s - recording.delay_s
    for j in range(n):
        for i in range(n):
            rows = np.flatnonzero((source == j + 1) & (destination == i + 1)) if i != j else ()
            if len(rows):
                adjacency[:, i, j] = _is_heard(t_s, arrived_s[rows], left_s[rows], window_s)
    adjacency &= alive[:, :, np.newaxis] & alive[:, np.newaxis, :]
    return Graphs(t_s, adjacency, alive)


def _is_heard(t_s: FloatArray, arrived_s: FloatArray, left_s: FloatArray, window_s: float) -> BoolArray:
    """Return (T,) whether the newest packet on a link was sent at most this long ago."""
    order = np.argsort(arrived_s, kind="stable")
    newest_s = np.concatenate([[-np.inf], np.maximum.accumulate(left_s[order])])
    count = np.searchsorted(arrived_s[order], t_s + _TOLERANCE_S, side="right")
    heard: BoolArray = t_s - newest_s[count] <= window_s + _TOLERANCE_S
    return heard


def laplacian(adjacency: NDArray[Any]) -> FloatArray:
    """Return L = D - A (..., N, N), the in-degrees (vehicles heard) in D, so that its rows sum to zero."""
    weights = np.asarray(adjacency, dtype=np.float64)
    n = weights.shape[-1]
    degrees: FloatArray = weights.sum(axis=-1)[..., np.newaxis] * np.eye(n) - weights
    return degrees


def algebraic_connectivity(adjacency: BoolArray, alive: BoolArray) -> FloatArray:
    """Return lambda_2 (T,) of the mirror graphs of the vehicles that are left, at least two."""
    mirror = 0.5 * (adjacency + np.swapaxes(adjacency, -1, -2).astype(np.float64))
    eigenvalues = np.linalg.eigvalsh(laplacian(mirror))
    gone = alive.shape[1] - alive.sum(axis=1)
    second = np.take_along_axis(eigenvalues, gone[:, np.newaxis] + 1, axis=1)[:, 0]
    value: FloatArray = np.maximum(second, 0.0)
    return value


def strong_parts(adjacency: BoolArray, alive: BoolArray) -> NDArray[np.int64]:
    """Return (T,) the number of strongly connected parts of the graph of the vehicles that are left."""
    n = adjacency.shape[-1]
    reached = adjacency | np.eye(n, dtype=bool)
    for _ in range(max(1, (n - 1).bit_length())):
        reached = np.matmul(reached.astype(np.float32), reached.astype(np.float32)) > 0.0
    mutual = reached & np.swapaxes(reached, -1, -2)
    is_first = ~(mutual & np.tri(n, k=-1, dtype=bool)).any(axis=-1)
    count: NDArray[np.int64] = (is_first & alive).sum(axis=1)
    return count
