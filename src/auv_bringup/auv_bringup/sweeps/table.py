"""
The table of a sweep: one row per run, in one Parquet file that says by itself what was asked for.

Columns: ``run``; ``scenario.<dotted path>`` for every parameter; ``seed``, ``key``, ``status`` (done or
failed), ``error``; every metric under its name; ``wall_s`` and ``cpu_s``.  Rows stand in the study's order,
so that all but the last two columns are the same however the runs were flown.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from auv_bringup.results import ResultsError
from auv_bringup.sweeps.plan import PlannedRun
from auv_bringup.sweeps.study import Study, is_number, study_from_plain, value_text
from auv_bringup.sweeps.worker import Finished
from auv_bringup.whole_files import whole_file
from auv_core.params import ConfigError, dump

TABLE_FILE = "runs.parquet"
DONE, FAILED = "done", "failed"
PREFIX = "scenario."
WALL_CLOCK_COLUMNS = ("wall_s", "cpu_s")
_ABOUT = b"shoal"
_FIXED = {"run", "seed", "key", "status", "error", *WALL_CLOCK_COLUMNS}


@dataclass(frozen=True, eq=False)
class SweepTable:
    """
    A table that was read.

    Attributes
    ----------
    study : Study
        What was asked for.
    making : dict
        How it was made, words by name.
    columns : dict
        Values by name of the column.

    """

    study: Study
    making: dict[str, str]
    columns: dict[str, list[Any]]
    _texts: frozenset[str]

    @property
    def n_runs(self) -> int:
        """Number of rows."""
        return len(self.columns["run"])

    def parameters(self, row: int) -> dict[str, Any]:
        """Return the values of the parameters in a row, by dotted path, as the study has them."""
        values = {path: self.columns[PREFIX + path][row] for path in self.study.parameters}
        return {path: json.loads(value) if path in self._texts else value for path, value in values.items()}

    @property
    def metrics(self) -> list[str]:
        """Names of the columns that are metrics."""
        return [name for name in self.columns if name not in _FIXED and not name.startswith(PREFIX)]


def write_table(
    folder: Path, study: Study, rows: Sequence[tuple[PlannedRun, Finished]], making: dict[str, str]
) -> Path:
    """
    Write the table of a sweep, all or nothing.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    study : Study
        What was asked for.
    rows : sequence of (PlannedRun, Finished)
        In the study's order.
    making : dict
        How it was made, words by name; kept in the file.

    """
    columns = {name: pa.array(values) for name, values in _columns(study, rows).items()}
    texts = [path for path in study.parameters if not _is_one_type([r.parameters[path] for r, _ in rows])]
    about = json.dumps({"study": dump(study), "making": making, "texts": texts}, allow_nan=False)
    table = pa.table(columns).replace_schema_metadata({_ABOUT: about.encode()})
    path = folder / TABLE_FILE
    with whole_file(path) as unfinished:
        pq.write_table(table, unfinished, write_page_checksum=True)
    return path


def read_table(folder: Path) -> SweepTable:
    """
    Return the table in a folder.

    Raises
    ------
    ResultsError
        When there is none, or it is not a sweep's.

    """
    path = folder / TABLE_FILE
    try:
        table = pq.read_table(path)
        about = json.loads((table.schema.metadata or {})[_ABOUT])
        study = study_from_plain(about["study"])
        return SweepTable(study, about["making"], table.to_pydict(), frozenset(about["texts"]))
    except OSError as error:
        raise ResultsError(f"{path}: cannot be read ({error.strerror or 'no such table'})") from None
    except (pa.ArrowException, LookupError, ValueError, TypeError, ConfigError):
        raise ResultsError(f"{path}: not the table of a sweep") from None


def _columns(study: Study, rows: Sequence[tuple[PlannedRun, Finished]]) -> dict[str, list[Any]]:
    runs, results = [run for run, _ in rows], [finished for _, finished in rows]
    names = dict.fromkeys(name for finished in results for name in finished.metrics)
    return {
        "run": [run.index for run in runs],
        **{PREFIX + path: _of_one_type([run.parameters[path] for run in runs]) for path in study.parameters},
        "seed": [run.seed for run in runs],
        "key": [run.key for run in runs],
        "status": [FAILED if finished.error else DONE for finished in results],
        "error": [finished.error for finished in results],
        **{name: _of_one_type([finished.metrics.get(name) for finished in results]) for name in names},
        "wall_s": [finished.wall_s for finished in results],
        "cpu_s": [finished.cpu_s for finished in results],
    }


def _of_one_type(values: Iterable[Any]) -> list[Any]:
    """Return values as Parquet wants them: all numbers, truth values or words, or else each as its text."""
    found = list(values)
    if not _is_one_type(found):
        return [value_text(value) for value in found]
    if any(isinstance(value, float) for value in found):
        return [None if value is None else float(value) for value in found]
    return found


def _is_one_type(values: Sequence[Any]) -> bool:
    given = [value for value in values if value is not None]
    return (
        all(is_number(value) for value in given)
        or all(isinstance(value, bool) for value in given)
        or all(isinstance(value, str) for value in given)
    )
