"""The summary of a sweep, made from its table alone: metrics over groups of runs, in one CSV file."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from auv_core.machine.whole_files import whole_file
from auv_experiment.metrics.wording import meaning_of
from auv_experiment.sweeps.confidence import Summary, summarise
from auv_experiment.sweeps.study import is_number
from auv_experiment.sweeps.table import DONE, PREFIX, SweepTable

SUMMARY_FILE = "summary.csv"
_USUAL = (
    "collision",
    "pair_distance_min_m",
    "pair_distance_min_after_150s_m",
    "pair_distance_max_after_200s_m",
    "centroid_path_rms_after_200s_m",
    "position_rms_m",
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
    column, status = table.columns.get(name), table.columns["status"]
    values = [column[row] for row in group.rows if status[row] == DONE] if column else []
    return summarise(
        [value for value in values if isinstance(value, bool) or is_number(value)],
        is_share=meaning_of(name).is_share,
    )


def n_failed(table: SweepTable, group: Group) -> int:
    """Return how many runs of a group failed."""
    return sum(table.columns["status"][row] != DONE for row in group.rows)


def grid_groups(table: SweepTable) -> list[Group]:
    """Return one group for every point of the grid; sampled parameters are pooled."""
    return groups_by(table, tuple(table.study.grid or {}))


def write_summary(folder: Path, table: SweepTable) -> Path:
    """Write the statistics of every metric at every point of the grid, one line each."""
    path = folder / SUMMARY_FILE
    grid = tuple(table.study.grid or {})
    with whole_file(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        words = [field.name for field in fields(Summary)]
        writer.writerow([*(PREFIX + name for name in grid), "metric", "runs", "failed", *words])
        for group in grid_groups(table):
            for name in table.metrics:
                counts = (len(group.rows), n_failed(table, group))
                numbers = astuple(metric_of(table, name, group))
                writer.writerow([*group.values.values(), name, *counts, *numbers])
    return path
