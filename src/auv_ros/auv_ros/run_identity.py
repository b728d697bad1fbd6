"""
Which run a status tells of: one check for all that act on /flock/status.

Any program that offers what the run's own writers offer can publish there, another run or a forger.
"""

from __future__ import annotations

from typing import Any, NamedTuple

UNKNOWN_EPOCH_S = 0.0
"""Stands for the stamp of scenario time 0 where that is not known yet."""
_EPOCH_TOLERANCE_S = 1e-3


class RunPoint(NamedTuple):
    """What a status says: the state, the scenario time reached, the length, and the stamp of time 0 (s)."""

    state: str
    time_s: float
    duration_s: float
    epoch_s: float = UNKNOWN_EPOCH_S


def status_epoch_s(status: Any) -> float:
    """Return the stamp of scenario time 0 (s) of the run that an auv_msgs/FlockStatus tells of."""
    stamp = status.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec - status.time_s)


def run_point(status: Any) -> RunPoint:
    """Return what an auv_msgs/FlockStatus says of its run."""
    return RunPoint(status.state, status.time_s, status.duration_s, status_epoch_s(status))


def is_of_run(known: RunPoint, said: RunPoint) -> bool:
    """Return whether both are points of one run: same length and, where it is known, same epoch."""
    is_same_epoch = abs(said.epoch_s - known.epoch_s) < _EPOCH_TOLERANCE_S
    return said.duration_s == known.duration_s and (is_same_epoch or known.epoch_s == UNKNOWN_EPOCH_S)


def follows(known: RunPoint, said: RunPoint) -> bool:
    """
    Return whether the clock of a run can say something after what is known of the run.

    It is of that run and not before it. A run finishes where its length is reached, and goes on before that.
    """
    is_at_end = said.time_s >= said.duration_s
    is_possible = said.state == "aborted" or is_at_end == (said.state == "finished")
    return is_of_run(known, said) and said.time_s >= known.time_s and is_possible
