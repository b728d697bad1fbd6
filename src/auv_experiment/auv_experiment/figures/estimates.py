"""
Figures of estimates: own navigation, neighbour estimates, their age, and their consistency.

Errors of estimates are relative to the own navigation; see `metrics_acoustics`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from auv_experiment.figures import Drawing
from auv_experiment.figures.plotting import (
    MAX_LINES,
    legend_below,
    log_scale,
    marker,
    new_canvas,
    plot_band,
    plot_thinned,
    side_by_side,
    span_time,
    two_sigma_handle,
    vehicle_style,
)
from auv_experiment.metrics import acoustics as metrics_acoustics
from auv_experiment.metrics.neighbours import (
    TAILS,
    JudgedErrors,
    judged_errors,
    neighbour_error_ned_m,
    neighbour_sigma_m,
    tail_shares,
)
from auv_experiment.metrics.windows import AGES_S
from auv_experiment.recording import FloatArray, IntArray, Recording

ZOOM_S = 30.0
_MOST_WINDOWS = 150
_CHI2_3_BAND = (0.2158, 9.3484)
"""Central 95 % of a chi-square distribution with three degrees of freedom."""
_RADIUS_95PCT_SD = 2.4477
"""
Radius that contains 95 % of an isotropic Gaussian distribution in the plane, in standard deviations per axis.
"""


def _draw_estimate_error(recording: Recording) -> Drawing | None:
    if not recording.has_neighbours:
        return None
    error_m = neighbour_error_ned_m(recording)
    if not np.isfinite(error_m).any():
        return None
    sigma_m = neighbour_sigma_m(recording)
    square_m2 = (error_m * error_m).sum(axis=-1)
    i, j = _worst_pair(square_m2)
    t_s = recording.t_s[:-1]
    window = _zoom_window(t_s)
    canvas = new_canvas(6.6)
    grid = canvas.subplots(4, 2, width_ratios=(5, 3), sharex="col", sharey="row")
    for row, component in enumerate(("north", "east", "down")):
        for axes, shown in zip(grid[row], (slice(None), window), strict=True):
            plot_band(axes, t_s[shown], 2.0 * sigma_m[shown, i, j, row])
            plot_thinned(axes, t_s[shown], error_m[shown, i, j, row], color="black", linewidth=0.8)
        grid[row, 0].set_ylabel(f"{component} error (m)")
        limit_m = 1.08 * _largest_of_band(error_m[:, i, j, row], 2.0 * sigma_m[:, i, j, row], t_s)
        grid[row, 0].set_ylim(-limit_m, limit_m)
    rms_m = _rms_over_pairs(square_m2)
    for axes, shown in zip(grid[3], (slice(None), window), strict=True):
        plot_thinned(axes, t_s[shown], rms_m[shown], color="black", linewidth=0.9)
        axes.set_xlabel("time (s)")
        span_time(axes, t_s[shown])
    log_scale(grid[3, 0], rms_m)
    grid[3, 0].set_ylabel("rms, all pairs (m)")
    ids = recording.vehicle_ids
    grid[0, 0].set_title(f"{ids[i]} estimates {ids[j]}: the worst pair")
    grid[0, 1].set_title(f"detail: {t_s[window][0]:.0f} to {t_s[window][-1]:.0f} s")
    handles = [Line2D([], [], color="black", linewidth=0.9), two_sigma_handle()]
    legend_below(canvas, handles, ["estimate minus truth", "two of the filter's own standard deviations"])
    caption = (
        f"Error of {ids[i]}'s estimate of the relative position of {ids[j]}: the ordered pair with the "
        "largest error. Grey: plus and minus two of the filter's own standard deviations; the error of a "
        "consistent filter stays inside about 95 % of the time. The band grows without packets and shrinks "
        "with each one. Below, the root mean square over all ordered pairs."
    )
    return Drawing(canvas, "Neighbour estimates", caption)


def _draw_information_age(recording: Recording) -> Drawing | None:
    if not recording.has_neighbours:
        return None
    age_s = _between_vehicles(recording, recording.neighbour_age_s)
    if not metrics_acoustics.has_modem(recording) or not np.isfinite(age_s).any():
        return None
    t_s = recording.t_s[:-1]
    sonar_age_s = _between_vehicles(recording, recording.neighbour_sonar_age_s)
    canvas = new_canvas(3.2)
    left, right = side_by_side(canvas, 2)
    middle_s, (low, median, high, most) = _in_windows(t_s, age_s, (0.05, 0.5, 0.95, 1.0))
    left.fill_between(middle_s, low, high, facecolor="0.82", linewidth=0.0, label="5 to 95 %")
    left.plot(middle_s, median, color="black", label="median")
    left.plot(middle_s, most, color="black", linewidth=0.7, linestyle=(0, (1.5, 1.2)), label="largest")
    if np.isfinite(sonar_age_s).any():
        _, (seen,) = _in_windows(t_s, sonar_age_s, (0.5,))
        left.plot(middle_s, seen, color="#c84b00", linestyle="dashed", label="since seen by sonar")
    window = _zoom_window(t_s, min(max(20.0 * float(np.nanmedian(age_s)), 10.0), 60.0))
    for j in range(1, min(recording.n_vehicles, MAX_LINES)):
        style = {**vehicle_style(j), "marker": marker(j), "linewidth": 0.9}
        words = f"of {recording.vehicle_ids[j]}"
        plot_thinned(
            right,
            t_s[window],
            age_s[window][:, 0, j],
            label=words,
            n_marks=6,
            first_mark=j / MAX_LINES,
            **style,
        )
    left.set_ylabel("age of the newest packet (s)")
    left.set_title("all pairs: age of neighbour estimates")
    right.set_title(f"{recording.vehicle_ids[0]} alone, {t_s[window][0]:.0f} to {t_s[window][-1]:.0f} s")
    for axes, shown in ((left, slice(None)), (right, window)):
        axes.set_ylim(0.0, None)
        axes.set_xlabel("time (s)")
        span_time(axes, t_s[shown])
    handles, labels = left.get_legend_handles_labels()
    more, names = right.get_legend_handles_labels()
    legend_below(canvas, [*handles, *more], [*labels, *names])
    caption = (
        f"Time since the time tag of the newest packet from a neighbour: median {np.nanmedian(age_s):.2f} s, "
        f"95 % below {np.nanquantile(age_s, 0.95):.2f} s, at most {np.nanmax(age_s):.1f} s. It grows by one "
        "second per second and drops with each packet to that packet's delay; a lost packet gives a tooth "
        f"of twice the height. Right, the estimates of {recording.vehicle_ids[0]} alone."
    )
    if np.isfinite(sonar_age_s).any():
        caption += " Dashed: the time since the sonar last saw a neighbour, median over the pairs that did."
    return Drawing(canvas, "Age of information", caption)


def _draw_nees(recording: Recording) -> Drawing | None:
    if not metrics_acoustics.has_modem(recording):
        return None
    ticks = metrics_acoustics.judged_ticks(recording, 0.0)
    nees = metrics_acoustics.neighbour_nees(recording, ticks, 3)
    if not np.isfinite(nees).any():
        return None
    t_s = recording.t_s[ticks]
    errors = judged_errors(recording)
    middle_s, (low, high) = _in_windows(t_s, nees, (0.025, 0.975))
    mean = _means_in_windows(t_s, nees)
    canvas = new_canvas(3.2)
    axes, by_age = side_by_side(canvas, 2, (5, 3))
    _draw_tails(by_age, errors)
    axes.axhspan(*_CHI2_3_BAND, facecolor="0.88", linewidth=0.0)
    axes.axhline(3.0, color="0.45", linewidth=1.0)
    axes.plot(middle_s, mean, color="black", linewidth=1.3)
    for edge in (low, high):
        axes.plot(middle_s, edge, color="black", linewidth=0.8, linestyle=(0, (1.5, 1.2)))
    log_scale(axes, np.concatenate([low, high, mean]))
    bottom, top = axes.get_ylim()
    axes.set_ylim(min(bottom, 0.6 * _CHI2_3_BAND[0]), max(top, 1.6 * _CHI2_3_BAND[1]))
    axes.set_xlabel("time (s)")
    axes.set_ylabel("NEES of relative positions")
    span_time(axes, t_s)
    handles = [
        Line2D([], [], color="black", linewidth=1.3, label="mean over pairs"),
        Line2D([], [], color="black", linewidth=0.8, linestyle=(0, (1.5, 1.2)), label="95 % of them"),
        Line2D([], [], color="0.45", label="expected mean"),
        Patch(facecolor="0.88", label="95 % of them expected"),
        *by_age.get_legend_handles_labels()[0],
    ]
    legend_below(canvas, handles)
    inside = nees[np.isfinite(nees)]
    share = ((inside >= _CHI2_3_BAND[0]) & (inside <= _CHI2_3_BAND[1])).mean()
    caption = (
        "Squared error of relative positions, normalised by the filter's own covariance (NEES). Above the "
        f"band the filters are overconfident, below it they are cautious. {share:.1%} of all values lie "
        "inside; 95 % are expected. Pairs share senders and receivers, so their mean scatters more than "
        "that of independent pairs. Right, the share of values beyond the 95 % and the 99.7 % point of a "
        "consistent filter, by the age of the newest packet; dotted: expected."
    )
    return Drawing(canvas, "Consistency of the neighbour filters", caption)


def _draw_tails(axes: Any, errors: JudgedErrors) -> None:
    """Draw the share of NEES beyond the tail points by age, in per cent, with what is expected."""
    places = range(len(AGES_S))
    for index, (name, expected) in enumerate((("95", 5.0), ("997", 0.3))):
        shares = [math.nan if share is None else 100.0 * share for share in tail_shares(errors, TAILS[name])]
        style = {**vehicle_style(index), "marker": marker(index)}
        axes.plot(places, shares, label=f"beyond {100.0 - expected:g} %", **style)
        axes.axhline(expected, color=style["color"], linewidth=0.8, linestyle="dotted")
    axes.set_yscale("symlog", linthresh=0.1)
    axes.set_ylim(0.0, 100.0)
    axes.set_yticks((0.0, 0.1, 1.0, 10.0, 100.0), ("0", "0.1", "1", "10", "100"))
    axes.set_xticks(places, [f"{low_s}-" for low_s in AGES_S])
    axes.set_xlabel("age from (s)")
    axes.set_ylabel("share in the tail (%)")


def _draw_navigation_drift(recording: Recording) -> Drawing | None:
    if metrics_acoustics.is_navigation_exact(recording):
        return None
    error_m = np.linalg.norm(metrics_acoustics.navigation_error_ned_m(recording)[..., :2], axis=-1)
    t_s, n = recording.t_s[:-1], recording.n_vehicles
    canvas = new_canvas(3.2)
    axes = canvas.add_subplot()
    sd_m = recording.nav_position_sd_m
    handles = []
    if (np.nan_to_num(sd_m) > 0.0).any():
        radius_m = _RADIUS_95PCT_SD * np.where(np.isfinite(sd_m), sd_m, -np.inf).max(axis=1)
        radius_m = np.where(np.isfinite(radius_m), radius_m, np.nan)
        axes.fill_between(t_s, 0.0, radius_m, facecolor="0.88", linewidth=0.0)
        handles = [Patch(facecolor="0.88", label="95 %, as stated")]
    for i in range(n):
        style = vehicle_style(i) if n <= MAX_LINES else {"color": "0.4", "linewidth": 0.4}
        if n <= MAX_LINES:
            style |= {
                "marker": marker(i),
                "n_marks": 7,
                "first_mark": i / n,
                "label": recording.vehicle_ids[i],
            }
        plot_thinned(axes, t_s, error_m[:, i], **style)
    axes.set_ylim(0.0, None)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("horizontal error (m)")
    span_time(axes, t_s)
    legend_below(canvas, [*handles, *axes.get_legend_handles_labels()[0]])
    caption = (
        "Horizontal error of the vehicles' own navigation. Grey: the error that the navigation states; over "
        "many runs 95 % of the errors should lie inside, but the errors of one vehicle persist. No law "
        "knows this error; vehicles with equal drift stay together."
    )
    return Drawing(canvas, "Drift of the navigation", caption)


def _between_vehicles(recording: Recording, values: FloatArray) -> FloatArray:
    """Return (K, N, N) values, NaN on the diagonal and where not finite."""
    is_own = np.eye(recording.n_vehicles, dtype=bool)
    return np.where(np.isfinite(values) & ~is_own, values, np.nan)


def _windows(t_s: FloatArray) -> list[IntArray]:
    """Return the rows of each of several equal parts of a run."""
    return np.array_split(np.arange(len(t_s)), min(_MOST_WINDOWS, max(1, len(t_s) // 4)))


def _in_windows(
    t_s: FloatArray, values: FloatArray, shares: tuple[float, ...]
) -> tuple[FloatArray, list[FloatArray]]:
    """
    Return the middle of each window (s), and the quantiles of all finite values in it, NaN without values.
    """
    windows = _windows(t_s)
    quantiles = np.full((len(shares), len(windows)), np.nan)
    for column, rows in enumerate(windows):
        finite = values[rows][np.isfinite(values[rows])]
        if finite.size:
            quantiles[:, column] = np.quantile(finite, shares)
    return np.array([t_s[rows].mean() for rows in windows]), list(quantiles)


def _means_in_windows(t_s: FloatArray, values: FloatArray) -> FloatArray:
    """Return the mean of all finite values in each window, NaN without values."""
    finite = [values[rows][np.isfinite(values[rows])] for rows in _windows(t_s)]
    return np.array([piece.mean() if piece.size else np.nan for piece in finite])


def _worst_pair(square_m2: FloatArray) -> tuple[int, int]:
    """Return the ordered pair (i, j) with the largest mean square error in the later half of its data."""
    late = square_m2[len(square_m2) // 2 :]
    late = late if np.isfinite(late).any() else square_m2
    total = np.where(np.isfinite(late), late, 0.0).sum(axis=0)
    mean = total / np.maximum(np.isfinite(late).sum(axis=0), 1)
    i, j = np.unravel_index(int(mean.argmax()), mean.shape)
    return int(i), int(j)


def _rms_over_pairs(square_m2: FloatArray) -> FloatArray:
    flat = square_m2.reshape(len(square_m2), -1)
    count = np.isfinite(flat).sum(axis=1)
    mean = np.where(np.isfinite(flat), flat, 0.0).sum(axis=1) / np.maximum(count, 1)
    rms: FloatArray = np.where(count > 0, np.sqrt(mean), np.nan)
    return rms


def _zoom_window(t_s: FloatArray, length_s: float = ZOOM_S) -> slice:
    """Return the rows of `length_s` from the middle of the run on, or all of a short run."""
    start_s = float(t_s[-1]) / 2.0
    window = np.flatnonzero((t_s >= start_s) & (t_s <= start_s + length_s))
    return slice(window[0], window[-1] + 1) if len(window) > 2 else slice(None)


def _largest_of_band(error_m: FloatArray, two_sigma_m: FloatArray, t_s: FloatArray) -> float:
    """Return the largest error of all, or of the band once the first tenth has passed (m)."""
    late = two_sigma_m[t_s >= 0.1 * t_s[-1]]
    largest = [float(np.nanmax(x)) for x in (np.abs(error_m), late) if np.isfinite(x).any()]
    return max([*largest, 1e-9])


ESTIMATE_DRAWERS: dict[str, Callable[[Recording], Drawing | None]] = {
    "estimate_error": _draw_estimate_error,
    "nees": _draw_nees,
    "information_age": _draw_information_age,
    "navigation_drift": _draw_navigation_drift,
}
"""By name, in the order in which a report shows them."""
