"""Packets by link: how many could have been received, and how many were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from auv_experiment.metrics.finite import largest, mean
from auv_experiment.recording import BoolArray, Recording


def link_counts(recording: Recording) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Count the packets on every link.

    Returns
    -------
    expected, delivered : (N, N) arrays of int64
        [i, j] counts packets that vehicle i sent while vehicle j was not lost, and those of them that
        vehicle j received. Receptions of packets that were never sent do not count.

    """
    n = recording.n_vehicles
    expected = np.zeros((n, n), dtype=np.int64)
    delivered = np.zeros((n, n), dtype=np.int64)
    if len(recording.sent) == 0 or n < 2:
        return expected, delivered
    tick, source = recording.sent[:, 0], recording.sent[:, 1] - 1
    alive = ~recording.is_gone[np.clip(tick, 0, recording.n_ticks)]
    np.add.at(expected, source, alive.astype(np.int64))
    np.fill_diagonal(expected, 0)

    row, is_known = _sent_row_of_receptions(recording)
    destination = recording.received[:, 2] - 1
    is_known &= (destination >= 0) & (destination < n)
    row, destination = row[is_known], destination[is_known]
    counts = alive[row, destination] & (source[row] != destination)
    np.add.at(delivered, (source[row][counts], destination[counts]), 1)
    return expected, delivered


def packet_metrics(recording: Recording) -> dict[str, float | None]:
    """
    Return the number of sent packets, and their outcomes.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; a vehicle that was lost when a packet left does not count as a receiver.

    """
    expected, delivered = link_counts(recording)
    is_possible = expected.sum() > 0
    return {
        "packets_sent": len(recording.sent),
        "packet_delivery_ratio": delivered.sum() / expected.sum() if is_possible else None,
        "packet_delay_mean_s": mean(recording.delay_s),
        "packet_delay_max_s": largest(recording.delay_s),
    }


def _sent_row_of_receptions(recording: Recording) -> tuple[NDArray[np.int64], BoolArray]:
    """Return for each reception the row of its packet in `sent`, and whether it exists."""
    sent_key = recording.sent[:, 1:3]
    received_key = recording.received[:, [1, 3]]
    _, key = np.unique(np.concatenate([sent_key, received_key]), axis=0, return_inverse=True)
    key = key.reshape(-1)
    row_of_key = np.full(key.max() + 1, -1, dtype=np.int64)
    row_of_key[key[: len(sent_key)]] = np.arange(len(sent_key))
    row = row_of_key[key[len(sent_key) :]]
    return row, row >= 0
