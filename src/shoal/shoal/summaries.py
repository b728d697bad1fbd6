"""Statistics of the table of a sweep: means and medians with confidence intervals that cover."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_core.params import ConfigError
from auv_experiment.metrics.wording import meaning_of
from auv_experiment.sweeps.statistics import summarise as summary_of
from auv_experiment.sweeps.table import DONE, FIXED_COLUMNS, PREFIX

if TYPE_CHECKING:
    import pandas as pd

GRID = "grid"
DRAW = "draw"


def summarise(table: pd.DataFrame, by: Sequence[str] | None = None) -> pd.DataFrame:
    """
    Return the statistics of every metric over groups of runs, as summary.csv of a sweep has them.

    Runs with the same seed, or with the same draw of a sample, are not independent: they are clusters of the
    confidence intervals. docs/how_to/sweeps.md shows how often the intervals cover.

    Parameters
    ----------
    table : pandas.DataFrame
        From `sweep`.
    by : sequence of str, optional
        Columns whose values make the groups; by default the parameters of the grid.

    Returns
    -------
    summary : pandas.DataFrame
        One row for each group and metric: the columns of `by`, ``metric``, ``runs``, ``failed``, ``n``,
        ``mean``, ``low``, ``high``, ``method``, ``clusters``, ``smallest``, ``median``, ``median_low``,
        ``median_high``, ``largest``.

    Raises
    ------
    ConfigError
        If the table has no such column.

    Examples
    --------
    >>> import shoal
    >>> table = shoal.sweep("flock_acoustic", seeds=range(3), duration_s=2.0, workers=1)
    >>> summary = shoal.summarise(table).set_index("metric")
    >>> summary.loc["pair_distance_min_m", "clusters"]
    '3 seeds'

    """
    import pandas as pd

    columns = list(table.attrs.get(GRID, ()) if by is None else by)
    if missing := [column for column in columns if column not in table]:
        raise ConfigError(f"by: {missing[0]} is not allowed; allowed: columns of the table")
    metrics = [name for name in table if name not in (*FIXED_COLUMNS, DRAW) and not name.startswith(PREFIX)]
    groups = table.groupby(columns, sort=False, dropna=False) if columns else [((), table)]
    rows = [
        {**dict(zip(columns, key, strict=True)), "metric": name, **_statistics(group, name)}
        for key, group in groups
        for name in metrics
    ]
    return pd.DataFrame(rows)


def _statistics(group: pd.DataFrame, name: str) -> dict[str, Any]:
    is_done = group["status"] == DONE
    values = [_plain(value) if done else None for value, done in zip(group[name], is_done, strict=True)]
    factors = {"seeds": group["seed"].tolist()}
    if DRAW in group:
        factors = {"draws": group[DRAW].tolist(), **factors}
    found = summary_of(values, factors, is_share=meaning_of(name).is_share)
    return {"runs": len(group), "failed": int((~is_done).sum()), **asdict(found)}


def _plain(value: Any) -> bool | float | None:
    """Return a cell of the table as truth value or number, None for all others."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    is_finite = isinstance(value, int | float | np.number) and np.isfinite(value)
    return float(value) if is_finite else None
