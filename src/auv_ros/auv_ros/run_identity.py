"""
The run that a status belongs to: one check for all nodes that act on /flock/status.

Any program with the quality of service of the run's own writers can publish there, such as another run.
"""

from __future__ import annotations

from typing import Any, NamedTuple

UNKNOWN_EPOCH_S = 0.0
"""Placeholder for the stamp of scenario time 0 until it is known."""
_EPOCH_TOLERANCE_S = 1e-3


class RunPoint(NamedTuple):
    """Content of a status: the state, the scenario time reached, the length, and the stamp of time 0 (s)."""

    state: str
    time_s: float
    duration_s: float
    epoch_s: float = UNKNOWN_EPOCH_S


def status_epoch_s(status: Any) -> float:
    """Return the stamp of scenario time 0 (s) of the run of an auv_msgs/FlockStatus."""
    stamp = status.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec - status.time_s)


def run_point(status: Any) -> RunPoint:
    """Return the content of an auv_msgs/FlockStatus."""
    return RunPoint(status.state, status.time_s, status.duration_s, status_epoch_s(status))


def is_of_run(known: RunPoint, said: RunPoint) -> bool:
    """Return whether both belong to one run: same length and, if it is known, same epoch."""
    is_same_epoch = abs(said.epoch_s - known.epoch_s) < _EPOCH_TOLERANCE_S
    return said.duration_s == known.duration_s and (is_same_epoch or known.epoch_s == UNKNOWN_EPOCH_S)


def follows(known: RunPoint, said: RunPoint) -> bool:
    """
    Return whether a status of a run's clock is plausible after the known status.

    It must belong to that run and not be earlier. A run finishes when its length is reached, and not before.
    """
    is_at_end = said.time_s >= said.duration_s
    is_possible = said.state == "aborted" or is_at_end == (said.state == "finished")
    return is_of_run(known, said) and said.time_s >= known.time_s and is_possible
