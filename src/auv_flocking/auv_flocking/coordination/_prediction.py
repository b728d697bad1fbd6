"""Path parameters of neighbours, predicted from their packets at the common speed."""

from __future__ import annotations

from collections.abc import Sequence

from auv_flocking.coordination import LanePlace, Pace
from auv_flocking.lanes.status import LaneNeighbour, apart_m


def ahead_m(own: LanePlace, other: LaneNeighbour, pace: Pace) -> float:
    """Return gamma_i - gamma_hat_j (m), with gamma_hat_j = gamma_j + v_L (t - t_j)."""
    predicted_m = other.status.gamma_m + pace.speed_mps * (own.t_s - other.time_s)
    return apart_m(own.gamma_m, predicted_m, pace.round_m)


def mean_ahead_m(own: LanePlace, others: Sequence[LaneNeighbour], pace: Pace) -> float:
    """Return gamma_i minus the mean of the neighbours' gamma_hat_j (m); 0 without neighbours."""
    if not others:
        return 0.0
    return sum([ahead_m(own, other, pace) for other in others]) / len(others)
