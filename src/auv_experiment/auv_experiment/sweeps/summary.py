"""
The summary of a sweep, made from its table alone: metrics over groups of runs, and differences between them.

Runs with the same sampled values are a cluster, a draw, and so are runs with the same seed
(`auv_experiment.confidence.clusters`).
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from auv_core.machine.whole_files import whole_file
from auv_experiment.metrics.wording import meaning_of
from auv_experiment.sweeps.statistics import Difference, Factors, Summary, compare, summarise
from auv_experiment.sweeps.study import is_number
from auv_experiment.sweeps.table import DONE, PREFIX, SweepTable

SUMMARY_FILE = "summary.csv"
DIFFERENCES_FILE = "differences.csv"
_USUAL = (
    "collision",
    "near_pairs",
    "pair_distance_min_m",
    "pair_distance_min_after_150s_m",
    "pair_distance_max_after_200s_m",
    "centroid_path_formed_rms_m",
    "position_rms_m",
    "fleet_formed_at_s",
    "coordination_error_p95_m",
    "cross_track_rms_m",
    "obstacle_clearance_min_m",
    "packet_delivery_ratio",
    "neighbour_age_mean_s",
)


@dataclass(frozen=True)
class Group:
    """Runs with the same values of some parameters: these values by path, and the rows of the runs."""

    values: dict[str, Any]
    rows: tuple[int, ...]


def shown_metrics_of(table: SweepTable) -> list[str]:
    """Return the metrics to show: those of the study, or else the usual ones that some run has."""
    if table.study.metrics:
        return list(dict.fromkeys(table.study.metrics))
    return [name for name in _USUAL if any(value is not None for value in table.columns.get(name, ()))]


def groups_by(table: SweepTable, paths: Sequence[str]) -> list[Group]:
    """Return the runs grouped by the values of parameters, in the order of the table."""
    columns = [table.columns[PREFIX + path] for path in paths]
    found: dict[tuple[Any, ...], list[int]] = {}
    for row in range(table.n_runs):
        found.setdefault(tuple(column[row] for column in columns), []).append(row)
    return [Group(dict(zip(paths, key, strict=True)), tuple(rows)) for key, rows in found.items()]


def metric_of(table: SweepTable, name: str, group: Group) -> Summary:
    """Return the statistics of a metric over the finished runs of a group."""
    values = [_value(table, name, row) for row in group.rows]
    return summarise(values, _factors(table, group.rows), is_share=meaning_of(name).is_share)


def difference_of(table: SweepTable, name: str, group: Group, other: Group) -> Difference:
    """Return a metric's mean difference between two points of the grid, over the runs that are paired."""
    run_of = dict(zip(_pairing(table, other), other.rows, strict=True))
    paired = [
        (row, run_of[key])
        for row, key in zip(group.rows, _pairing(table, group), strict=True)
        if key in run_of
    ]
    values = [(_value(table, name, row), _value(table, name, partner)) for row, partner in paired]
    return compare(values, _factors(table, [row for row, _ in paired]))


def n_failed(table: SweepTable, group: Group) -> int:
    """Return how many runs of a group failed."""
    return sum(table.columns["status"][row] != DONE for row in group.rows)


def grid_groups(table: SweepTable) -> list[Group]:
    """Return one group for every point of the grid; sampled parameters are pooled."""
    return groups_by(table, tuple(table.study.grid or {}))


def neighbouring_groups(table: SweepTable) -> list[tuple[str, Group, Group]]:
    """Return the points that differ in one parameter from the point with its first value, and that point."""
    groups = {tuple(group.values.values()): group for group in grid_groups(table)}
    found = []
    for place, path in enumerate(table.study.grid or {}):
        first = table.columns[PREFIX + path][0]
        for key, group in groups.items():
            base = groups[(*key[:place], first, *key[place + 1 :])]
            if base is not group:
                found.append((path, group, base))
    return found


def write_summary(folder: Path, table: SweepTable) -> Path:
    """Write the statistics of every metric at every point of the grid, one line each."""
    rows = (
        [*group.values.values(), name, len(group.rows), n_failed(table, group), *vars(summary).values()]
        for group in grid_groups(table)
        for name in table.metrics
        for summary in [metric_of(table, name, group)]
    )
    path = folder / SUMMARY_FILE
    words = [field.name for field in fields(Summary)]
    _write(path, [*_grid_columns(table), "metric", "runs", "failed", *words], rows)
    return path


def write_differences(folder: Path, table: SweepTable) -> Path | None:
    """
    Write the paired differences of every metric between points that differ in one parameter.

    Without a second point there is no file, and one of an earlier call is removed.
    """
    path = folder / DIFFERENCES_FILE
    neighbours = neighbouring_groups(table)
    if not neighbours:
        path.unlink(missing_ok=True)
        return None
    rows = (
        [*group.values.values(), PREFIX + parameter, base.values[parameter], name, *vars(found).values()]
        for parameter, group, base in neighbours
        for name in table.metrics
        for found in [difference_of(table, name, group, base)]
        if found.pairs
    )
    words = [field.name for field in fields(Difference)]
    _write(path, [*_grid_columns(table), "differs_in", "from", "metric", *words], rows)
    return path


def _write(path: Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    with whole_file(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(rows)


def _grid_columns(table: SweepTable) -> list[str]:
    return [PREFIX + path for path in table.study.grid or {}]


def _value(table: SweepTable, name: str, row: int) -> bool | float | None:
    """Return a metric of a finished run, None if it has no such number or truth value."""
    column = table.columns.get(name)
    value = column[row] if column and table.columns["status"][row] == DONE else None
    return value if isinstance(value, bool) or is_number(value) else None


def _factors(table: SweepTable, rows: Sequence[int]) -> Factors:
    seeds = {"seeds": [table.columns["seed"][row] for row in rows]}
    return {"draws": [table.draw_of(row) for row in rows], **seeds} if table.study.sample else seeds


def _pairing(table: SweepTable, group: Group) -> list[tuple[int, int]]:
    """Return draw and seed of the runs of a group."""
    return [(table.draw_of(row), table.columns["seed"][row]) for row in group.rows]
