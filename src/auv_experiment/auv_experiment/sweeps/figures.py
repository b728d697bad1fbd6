"""
Figures of a sweep, one per metric, drawn from its table alone.

Against a parameter of the grid: the mean at each value with its 95 % interval, one line per value of the
other parameters. Against a sampled parameter: every run, and mean and interval over groups of equally many
draws. Without parameters: the distribution over the seeds with its interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from auv_experiment.figures import Drawing
from auv_experiment.figures.files import draw_files
from auv_experiment.figures.formats import FORMATS, PAGE_FORMAT
from auv_experiment.figures.plotting import colour, legend_below, marker, new_canvas, vehicle_style
from auv_experiment.metrics.wording import meaning_of
from auv_experiment.sweeps.labels import group_label, legend_title, metric_label, parameter_label, value_label
from auv_experiment.sweeps.statistics import Summary, distribution_band
from auv_experiment.sweeps.study import is_number
from auv_experiment.sweeps.summary import Group, groups_by, metric_of
from auv_experiment.sweeps.table import PREFIX, SweepTable

_DPI = 130
_BAND_OPACITY = 0.13
_EDGE_OPACITY = 0.6
_MAX_LINES = 12
_DRAWS_PER_MEAN = 8
_MOST_MEANS = 10


def write_figures(
    folder: Path, table: SweepTable, metrics: Sequence[str], formats: Sequence[str] = (PAGE_FORMAT,)
) -> dict[str, Path]:
    """Draw metrics; return the PNG files by metric. Metrics that no run has are left out."""
    folder.mkdir(parents=True, exist_ok=True)
    for file_format in FORMATS:
        for path in folder.glob(f"*.{file_format}"):  # of an earlier call, perhaps of other metrics
            path.unlink()
    paths = {}
    for name in metrics:
        if any(value is not None for value in table.columns.get(name, ())):
            draw_files(partial(draw_metric, table, name), folder / name, formats, dpi=_DPI)
            paths[name] = folder / f"{name}.{PAGE_FORMAT}"
    return paths


def draw_metric(table: SweepTable, name: str) -> Drawing:
    """Draw one metric."""
    canvas = new_canvas()
    axes = canvas.subplots()
    _draw_into(axes, table, name)
    handles, labels = axes.get_legend_handles_labels()
    if len(handles) > 1:
        legend_below(canvas, handles, labels, title=legend_title(table, line_parameters(table)))
    return Drawing(canvas, metric_label(table, name), meaning_of(name).words)


def _draw_into(axes: Any, table: SweepTable, name: str) -> None:
    axes.set_ylabel(metric_label(table, name))
    x = axis_parameter(table)
    if x is None:
        _draw_distribution(axes, table, name)
        return
    lines = [group for group in groups_by(table, line_parameters(table)) if _has(table, name, group)]
    is_drawn = table.study.sample is not None and x in table.study.sample.parameters
    is_numeric = all(is_number(value) for value in table.columns[PREFIX + x])
    found: list[Summary] = []
    for index, line in enumerate(lines[:_MAX_LINES]):
        if is_drawn and is_numeric:
            found += _draw_cloud(axes, table, name, x, line, index)
        else:
            found += _draw_means(axes, table, name, x, line, index, n_lines=len(lines[:_MAX_LINES]))
    words = _interval_words(found, is_truth=any(isinstance(value, bool) for value in table.columns[name]))
    axes.set_xlabel(f"{parameter_label(table, x)}\n{words}")
    if not is_numeric:
        values = _values_along(table, x)
        axes.set_xticks(range(len(values)), [value_label(table, x, value) for value in values])
    if len(lines) > _MAX_LINES:
        axes.set_title(f"the first {_MAX_LINES} of {len(lines)} lines; the summary has all")


def axis_parameter(table: SweepTable) -> str | None:
    """Return the parameter along the axis: the study's choice, or else the first one."""
    return table.study.x or next(iter(table.study.parameters), None)


def line_parameters(table: SweepTable) -> tuple[str, ...]:
    """Return the parameters whose values distinguish the lines; runs are pooled over the others."""
    if table.study.by is not None:
        return (table.study.by,)
    return tuple(path for path in table.study.grid or {} if path != axis_parameter(table))


def _interval_words(summaries: Sequence[Summary], *, is_truth: bool) -> str:
    """Return what the intervals of a figure are: of what, and over which clusters."""
    clusters = list(dict.fromkeys(summary.clusters for summary in summaries if summary.method))
    if not clusters:
        return "no intervals"
    return f"95 % intervals of the {'share' if is_truth else 'mean'} over {' or '.join(clusters[:3])}"


def _has(table: SweepTable, name: str, group: Group) -> bool:
    return metric_of(table, name, group).n > 0


def _values_along(table: SweepTable, path: str) -> list[Any]:
    return list(dict.fromkeys(table.columns[PREFIX + path]))


def _draw_means(
    axes: Any, table: SweepTable, name: str, x: str, line: Group, index: int, *, n_lines: int
) -> list[Summary]:
    """
    Draw mean and interval at each value of a parameter; values that are no numbers are placed side by side.
    """
    values = _values_along(table, x)
    is_numeric = all(is_number(value) for value in values)
    found: list[tuple[float, Summary]] = []
    for place, value in enumerate(values):
        rows = tuple(row for row in line.rows if table.columns[PREFIX + x][row] == value)
        summary = metric_of(table, name, Group({x: value}, rows))
        if summary.n:
            beside = 0.0 if is_numeric else 0.5 * ((index + 0.5) / n_lines - 0.5)
            found.append((float(value) if is_numeric else place + beside, summary))
    found.sort(key=lambda pair: pair[0])
    if is_numeric:
        _draw_band(axes, found, group_label(table, line), index)
        return [summary for _, summary in found]
    places, summaries = zip(*found, strict=True)
    means = np.array([summary.mean for summary in summaries], dtype=np.float64)
    bounds = np.array([_bounds(summary) for summary in summaries])
    style = {"color": colour(index), "marker": marker(index), "linestyle": "none", "capsize": 3.0}
    axes.errorbar(places, means, np.abs(bounds.T - means), label=group_label(table, line), **style)
    return list(summaries)


def _draw_band(axes: Any, found: Sequence[tuple[float, Summary]], label: str, index: int) -> None:
    places = np.array([place for place, _ in found])
    means = np.array([summary.mean for _, summary in found], dtype=np.float64)
    bounds = np.array([_bounds(summary) for _, summary in found])
    axes.fill_between(places, *bounds.T, color=colour(index), alpha=_BAND_OPACITY, linewidth=0.0)
    axes.plot(places, bounds, alpha=_EDGE_OPACITY, linewidth=0.7, **vehicle_style(index))
    axes.plot(places, means, marker=marker(index), label=label, **vehicle_style(index))


def _bounds(summary: Summary) -> tuple[float, float]:
    """Return the interval, or the mean twice if there is no interval."""
    mean = float("nan") if summary.mean is None else summary.mean
    return (mean if summary.low is None else summary.low, mean if summary.high is None else summary.high)


def _draw_cloud(axes: Any, table: SweepTable, name: str, x: str, line: Group, index: int) -> list[Summary]:
    """Draw every run, and mean and interval over groups of equally many draws along the axis."""
    along = table.columns[PREFIX + x]
    rows = sorted((row for row in line.rows if table.columns[name][row] is not None), key=along.__getitem__)
    heights = [float(table.columns[name][row]) for row in rows]
    axes.plot([along[row] for row in rows], heights, ".", color=colour(index), alpha=0.35, markersize=3.5)
    ordered = list(dict.fromkeys(map(table.draw_of, rows)))
    n_means = int(np.clip(len(ordered) // _DRAWS_PER_MEAN, 1, _MOST_MEANS))
    edges = np.linspace(0, len(ordered), n_means + 1).round().astype(int)
    found = []
    for first, last in pairwise(edges.tolist()):
        chosen = set(ordered[first:last])
        part = tuple(row for row in rows if table.draw_of(row) in chosen)
        place = float(np.mean([along[row] for row in part]))
        found.append((place, metric_of(table, name, Group({}, part))))
    _draw_band(axes, found, group_label(table, line), index)
    return [summary for _, summary in found]


def _draw_distribution(axes: Any, table: SweepTable, name: str) -> None:
    """Draw the share of runs below each value, with its band."""
    values = np.sort(np.array([v for v in table.columns[name] if v is not None], dtype=np.float64))
    share = np.arange(1, len(values) + 1) / len(values)
    half = distribution_band(len(values))
    band = np.clip(share - half, 0.0, 1.0), np.clip(share + half, 0.0, 1.0)
    axes.fill_between(values, *band, step="post", color=colour(1), alpha=_BAND_OPACITY, linewidth=0.0)
    axes.step(values, share, where="post", color=colour(1))
    axes.set(xlabel=metric_label(table, name), ylabel="share of runs that are not above", ylim=(0.0, 1.02))
