"""Neighbour estimates compared with the truth and with their own covariance."""

from __future__ import annotations

import numpy as np

from auv_experiment.metrics.acoustics import relative_position_error_ned_m
from auv_experiment.metrics.finite import largest, mean, norm, rms
from auv_experiment.metrics.windows import SETTLED_AFTER_S, after
from auv_experiment.recording import FloatArray, Recording

_KEYS = (
    "neighbour_position_rmse_m",
    "neighbour_within_2sigma_ratio",
    "neighbour_age_mean_s",
    "neighbour_age_max_s",
)


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
