"""
Metrics of acoustics and navigation: losses by cause, delays, drift, and consistency of the filters.

Shares of packets count every packet once per receiver, at all modems, including those of lost vehicles;
packets in transit at the end do not count. Neighbour estimates are compared as they are used, relative to the
own navigation, so that a common drift is no error.

NEES is the normalised estimation error squared, e' P^-1 e with the filter's own covariance P. For a
consistent filter with Gaussian errors it has a chi-square distribution, and its mean is the number of
components.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_core.messages import Outcome
from auv_experiment.metrics.finite import finite
from auv_experiment.metrics.windows import SETTLED_AFTER_S, after
from auv_experiment.recording import FloatArray, IntArray, Recording

LOSSES = (Outcome.OUTAGE, Outcome.NOISE, Outcome.COLLISION, Outcome.HALF_DUPLEX, Outcome.RANGE)
"""Causes in the order in which figures and tables show them."""
CHI2_3_95PCT = 7.8147
"""95 % quantile of a chi-square distribution with three degrees of freedom."""
_TOLERANCE_S = 1e-9
_MOST_ESTIMATES = 400_000
_STEPS = (1, 3, 7, 13, 29, 61, 127)


def acoustics_metrics(recording: Recording, *, formed_at_s: float = 0.0) -> dict[str, Any]:
    """
    Return the metrics of the acoustic network, of the navigation and of the neighbour filters.

    Parameters
    ----------
    recording : Recording
        The run.
    formed_at_s : float
        Time after which the filters are evaluated (s); NaN: never.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them, None for a quantity that does not exist. Metrics of packets and filters
        exist with a modem with airtime, those of the navigation if it is not exact. Since errors of a drift
        persist, `navigation_nees_mean` is a mean of few independent numbers.

    """
    metrics: dict[str, Any] = {}
    if has_modem(recording):
        metrics |= _packet_metrics(recording) | _filter_metrics(recording, formed_at_s)
        metrics["sonar_contacts"] = len(recording.contacts)
    if not is_navigation_exact(recording):
        metrics |= _navigation_metrics(recording)
    return metrics


def has_modem(recording: Recording) -> bool:
    """Return whether packets had airtime; the ideal medium has neither losses nor delays."""
    return bool((recording.event_values[:, 1] > recording.event_values[:, 0]).any())


def is_navigation_exact(recording: Recording) -> bool:
    """Return whether every navigation was exact, or none is recorded."""
    error_m = navigation_error_ned_m(recording)
    return not (np.isfinite(error_m) & (error_m != 0.0)).any()


def navigation_error_ned_m(recording: Recording) -> FloatArray:
    """Return the (K, N, 3) position by the own navigation minus the true one (m; NED), NaN after a loss."""
    error_m = recording.nav_position_ned_m - recording.position_ned_m[:-1]
    return np.where(recording.is_gone[:-1][..., np.newaxis], np.nan, error_m)


def loss_counts(recording: Recording) -> dict[Outcome, IntArray]:
    """
    Count the outcomes of packets on every link.

    Returns
    -------
    counts : dict of Outcome to (N, N) array
        For DELIVERED and each of `LOSSES`: [i, j] counts packets from vehicle i at vehicle j.

    """
    n = recording.n_vehicles
    outcome, source, destination = recording.events[:, 1], recording.events[:, 2], recording.events[:, 3]
    is_known = (np.minimum(source, destination) >= 1) & (np.maximum(source, destination) <= n)
    counts = {}
    for wanted in (Outcome.DELIVERED, *LOSSES):
        counts[wanted] = np.zeros((n, n), dtype=np.int64)
        rows = (outcome == wanted) & is_known
        np.add.at(counts[wanted], (source[rows] - 1, destination[rows] - 1), 1)
    return counts


def relative_error_ned(recording: Recording, ticks: IntArray) -> FloatArray:
    """
    Return the errors of neighbour estimates relative to the own navigation.

    Parameters
    ----------
    recording : Recording
        The run.
    ticks : (M,) array of int
        Ticks to evaluate.

    Returns
    -------
    error : (M, N, N, 6) array
        [., i, j]: (estimate of j - own navigation of i) - (true j - true i) (m; NED), then the estimate of
        j's velocity minus the true one (m/s; NED; from differences of the positions). NaN on the diagonal,
        where no estimate exists, and after the loss of either vehicle.
    """
    position_m = relative_position_error_ned_m(recording, ticks)
    true_mps = np.gradient(recording.position_ned_m, recording.t_s, axis=0)[ticks]
    velocity_mps = recording.neighbour_velocity_ned_mps[ticks] - true_mps[:, np.newaxis]
    velocity_mps[np.isnan(position_m)] = np.nan
    return np.concatenate([position_m, velocity_mps], axis=-1)


def relative_position_error_ned_m(recording: Recording, ticks: IntArray) -> FloatArray:
    """Return the (M, N, N, 3) positions of `relative_error_ned` (m; NED)."""
    truth, own = recording.position_ned_m[ticks], recording.nav_position_ned_m[ticks]
    # In a recording without navigation all vehicles have exact navigation.
    own = np.where(np.isfinite(own), own, truth)
    estimate = recording.neighbour_position_ned_m[ticks]
    error: FloatArray = estimate - truth[:, np.newaxis] - (own - truth)[:, :, np.newaxis]
    gone = recording.is_gone[ticks]
    nobody = gone[:, :, np.newaxis] | gone[:, np.newaxis] | np.eye(recording.n_vehicles, dtype=bool)
    return np.where(nobody[..., np.newaxis], np.nan, error)


def neighbour_nees(recording: Recording, ticks: IntArray, size: int) -> FloatArray:
    """
    Return the (M, N, N) NEES of the estimates at some ticks, NaN if there is no estimate.

    Parameters
    ----------
    recording : Recording
        The run.
    ticks : (M,) array of int
        Ticks to evaluate.
    size : int
        3 for the relative position alone, 6 with the velocity.

    """
    error_of = relative_position_error_ned_m if size == 3 else relative_error_ned
    error = error_of(recording, ticks)
    exists = np.asarray(np.isfinite(error).all(axis=-1))
    at, own, other = np.nonzero(exists)
    covariance = recording.neighbour_covariance[ticks[at], own, other, :size, :size]
    error = error[exists]
    sound = np.asarray(np.isfinite(covariance).all(axis=(-2, -1)))
    sound[sound] = np.linalg.det(covariance[sound]) > 0.0
    error, covariance = error[sound], covariance[sound]
    exists[exists] = sound
    nees = np.full(exists.shape, np.nan)
    weighted = np.linalg.solve(covariance, error[..., np.newaxis])[..., 0]
    nees[exists] = np.einsum("ni,ni->n", error, weighted)
    return nees


def judged_ticks(recording: Recording, from_s: float) -> IntArray:
    """
    Return the ticks for the evaluation of the filters: all after `from_s`, or evenly spaced ones in long
    runs.

    The step is a prime number, so that it is not in phase with the cycles of the medium.
    """
    (ticks,) = np.nonzero(recording.t_s[:-1] >= from_s - _TOLERANCE_S)
    count = len(ticks) * recording.n_vehicles**2
    step = next((step for step in _STEPS if count <= step * _MOST_ESTIMATES), _STEPS[-1])
    return ticks[::step]


def _packet_metrics(recording: Recording) -> dict[str, Any]:
    counts = {outcome: int(table.sum()) for outcome, table in loss_counts(recording).items()}
    total = sum(counts.values())
    sent = recording.events[:, 1] == Outcome.SENT
    on_air_s = recording.event_values[sent, 1] - recording.event_values[sent, 0]
    run_s = float(recording.t_s[-1] - recording.t_s[0])
    late = after(recording.t_s[:-1], SETTLED_AFTER_S)
    metrics: dict[str, Any] = {"packets_lost": total - counts[Outcome.DELIVERED]}
    for outcome in LOSSES:
        ratio = counts[outcome] / total if total else None
        metrics[f"packet_loss_{outcome.name.lower()}_ratio"] = ratio
    metrics["packet_delay_95pct_s"] = _quantile(recording.delay_s)
    metrics["acoustic_bit_rate_bps"] = 8.0 * float(recording.events[sent, 5].sum()) / run_s
    metrics["acoustic_load_ratio"] = float(on_air_s.sum()) / run_s
    age_s = recording.neighbour_age_s[late] if recording.has_neighbours else recording.neighbour_age_s
    metrics["neighbour_age_95pct_s"] = _quantile(age_s)
    return metrics


def _filter_metrics(recording: Recording, formed_at_s: float) -> dict[str, float | None]:
    is_judged = recording.has_neighbours and not math.isnan(formed_at_s)
    ticks = judged_ticks(recording, formed_at_s if is_judged else math.inf)
    position = finite(neighbour_nees(recording, ticks, 3))
    return {
        "neighbour_nees_position_mean": _mean(position),
        "neighbour_nees_mean": _mean(finite(neighbour_nees(recording, ticks, 6))),
        "neighbour_nees_within_95_ratio": _mean(position <= CHI2_3_95PCT),
    }


def _navigation_metrics(recording: Recording) -> dict[str, float | None]:
    error_m = navigation_error_ned_m(recording)
    sd_m = recording.nav_position_sd_m
    level_m2 = (error_m[..., :2] ** 2).sum(axis=-1)
    judged = (sd_m > 0.0) & np.isfinite(level_m2)
    square_m2 = (error_m**2).sum(axis=-1)
    return {
        "navigation_error_rms_m": _root(_mean(finite(square_m2))),
        "navigation_error_final_m": _root(_mean(finite(square_m2[-1:]))),
        "navigation_nees_mean": _mean(level_m2[judged] / sd_m[judged] ** 2),
    }


def _mean(values: NDArray[Any]) -> float | None:
    return float(values.mean()) if values.size else None


def _root(value: float | None) -> float | None:
    return None if value is None else math.sqrt(value)


def _quantile(values: FloatArray) -> float | None:
    known = finite(values)
    return float(np.quantile(known, 0.95)) if known.size else None
