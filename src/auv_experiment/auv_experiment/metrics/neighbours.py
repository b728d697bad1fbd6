"""
Neighbour estimates compared with the truth and with their own covariance.

The tails: how many squared errors of relative positions exceed the points that a consistent filter exceeds in
5 % and 0.3 % of cases, by the age of the newest packet and in the first minute. A mean can look cautious
while the tails are too heavy, and it is the tails that bring hulls together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from auv_experiment.metrics.acoustics import (
    CHI2_3_95PCT,
    has_modem,
    judged_ticks,
    neighbour_nees,
    relative_position_error_ned_m,
)
from auv_experiment.metrics.finite import largest, mean, norm, rms
from auv_experiment.metrics.windows import AGES_S, SETTLED_AFTER_S, after
from auv_experiment.recording import FloatArray, Recording

_KEYS = (
    "neighbour_position_rmse_m",
    "neighbour_within_2sigma_ratio",
    "neighbour_age_mean_s",
    "neighbour_age_max_s",
)

TAILS = {"95": CHI2_3_95PCT, "997": 13.9314}
"""The 95 % and 99.7 % points of a chi-square distribution with three degrees of freedom."""
FIRST_MINUTE_S = 60.0


class JudgedErrors(NamedTuple):
    """Time (s), age of the newest packet (s) and NEES of position of many estimates, (M,) each."""

    t_s: FloatArray
    age_s: FloatArray
    nees: FloatArray

    def between(self, from_s: float, to_s: float) -> JudgedErrors:
        """Return the estimates from `from_s` on and before `to_s` (s)."""
        rows = (self.t_s >= from_s) & (self.t_s < to_s)
        return JudgedErrors(self.t_s[rows], self.age_s[rows], self.nees[rows])


def neighbour_error_ned_m(recording: Recording) -> FloatArray:
    """
    Return the errors of every vehicle's estimates of the others' relative positions.

    An estimate is in the frame of the vehicle's own navigation, so it is compared relative to that
    navigation; with exact navigation this is the error of the position itself.

    Returns
    -------
    error : (K, N, N, 3) array
        [k, i, j] is (vehicle i's estimate of vehicle j's position - i's own navigation) - (true position of
        j - true position of i) (m, NED); NaN on the diagonal, where no estimate exists, and after the loss of
        either vehicle.

    """
    return relative_position_error_ned_m(recording, np.arange(recording.n_ticks))


def neighbour_sigma_m(recording: Recording) -> FloatArray:
    """Return the (K, N, N, 3) standard deviations of the position estimates (m, NED), from the filters."""
    variance = np.diagonal(recording.neighbour_covariance, axis1=-2, axis2=-1)[..., :3]
    return np.sqrt(np.where(variance >= 0.0, variance, np.nan))


def neighbour_metrics(recording: Recording) -> dict[str, float | None]:
    """
    Return error and age of the neighbour estimates.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them, for t > 100 s. Errors are of estimates relative to the own navigation,
        over ordered pairs.

    """
    if not recording.has_neighbours:
        return dict.fromkeys(_KEYS)
    late = after(recording.t_s[:-1], SETTLED_AFTER_S)
    error_m = neighbour_error_ned_m(recording)[late]
    sigma_m = neighbour_sigma_m(recording)[late]
    judged = np.isfinite(error_m) & np.isfinite(sigma_m)
    inside = np.abs(error_m[judged]) <= 2.0 * sigma_m[judged]
    age_s = recording.neighbour_age_s[late][np.isfinite(error_m).all(axis=-1)]
    values = (rms(norm(error_m)), mean(inside.astype(np.float64)), mean(age_s), largest(age_s))
    return dict(zip(_KEYS, values, strict=True))


def judged_errors(recording: Recording) -> JudgedErrors:
    """Return the estimates of a run that the filters' consistency is judged by, from the first packet on."""
    ticks = judged_ticks(recording, 0.0)
    nees = neighbour_nees(recording, ticks, 3)
    exists = np.isfinite(nees)
    t_s = np.broadcast_to(recording.t_s[ticks][:, np.newaxis, np.newaxis], nees.shape)
    return JudgedErrors(t_s[exists], recording.neighbour_age_s[ticks][exists], nees[exists])


def by_age(errors: JudgedErrors) -> list[FloatArray]:
    """Return the NEES of the estimates in each bin of `AGES_S`."""
    bins = np.searchsorted(AGES_S, errors.age_s, side="right") - 1
    return [errors.nees[bins == index] for index in range(len(AGES_S))]


def share_beyond(nees: FloatArray, point: float) -> float | None:
    """Return the share of NEES beyond a point of their distribution (`TAILS`), None if there are none."""
    return float((nees > point).mean()) if nees.size else None


def tail_shares(errors: JudgedErrors, point: float) -> list[float | None]:
    """Return the share of the NEES beyond `point` in each bin of `AGES_S`, None for an empty bin."""
    return [share_beyond(nees, point) for nees in by_age(errors)]


def tail_metrics(recording: Recording) -> dict[str, float | None]:
    """
    Return the shares in the tails, as `MEANINGS` describes them; none without a modem with airtime.
    """
    metrics: dict[str, float | None] = {}
    if not has_modem(recording):
        return metrics
    errors = judged_errors(recording)
    for name, point in TAILS.items():
        for low_s, share in zip(AGES_S, tail_shares(errors, point), strict=True):
            metrics[f"neighbour_nees_beyond_{name}_age_{low_s}s_ratio"] = share
        early = errors.between(0.0, FIRST_MINUTE_S).nees
        metrics[f"neighbour_nees_beyond_{name}_first_minute_ratio"] = share_beyond(early, point)
    return metrics
