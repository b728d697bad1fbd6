"""
The table of a sweep: one row per run, in one Parquet file that also contains the study.

Columns: ``run``; ``scenario.<dotted path>`` for every parameter; ``seed``, ``key``, ``status`` (done or
failed), ``error``; every metric under its name; ``wall_s`` and ``cpu_s``. Rows are in the study's order, so
that all but the last two columns do not depend on how the runs were flown.
"""

from __future__ import annotations

import errno
import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from auv_core.machine.failure import one_line
from auv_core.machine.whole_files import whole_file
from auv_core.params import ConfigError, dump
from auv_experiment.results import ResultsError
from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.study import MAX_RUNS, Study, is_number, study_from_plain, value_text
from auv_experiment.sweeps.worker import Finished

TABLE_FILE = "runs.parquet"
DONE, FAILED = "done", "failed"
PREFIX = "scenario."
WALL_CLOCK_COLUMNS = ("wall_s", "cpu_s")
_ABOUT = b"shoal"
_CHECKSUM = "checksum"
_KEYS_OF_OLD_TABLES = {"study", "making", "texts"}
_TYPES = {
    "run": pa.types.is_int64,
    "seed": pa.types.is_int64,
    "key": pa.types.is_string,
    "status": pa.types.is_string,
    "error": pa.types.is_string,
    **dict.fromkeys(WALL_CLOCK_COLUMNS, lambda found: pa.types.is_float64(found) or pa.types.is_null(found)),
}
FIXED_COLUMNS = tuple(_TYPES)
"""Columns that are neither parameters nor metrics."""
_SCALARS = (
    pa.types.is_int64,
    pa.types.is_float64,
    pa.types.is_boolean,
    pa.types.is_string,
    pa.types.is_null,
)
_ROWS_AT_ONCE = 256
_MOST_BYTES = 1 << 30


@dataclass(frozen=True, eq=False)
class SweepTable:
    """
    A table read from disk.

    Attributes
    ----------
    study : Study
        The study of the sweep.
    making : dict
        How it was made: texts by name.
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

    def draw_of(self, row: int) -> int:
        """Return the number of a row's random point, from 0; 0 in a study without a sample."""
        count = self.study.sample.count if self.study.sample else 1
        return int(self.columns["run"][row]) // len(self.study.seeds) % count

    def parameters(self, row: int) -> dict[str, Any]:
        """Return the values of the parameters in a row, by dotted path, as in the study."""
        values = {path: self.columns[PREFIX + path][row] for path in self.study.parameters}
        return {path: json.loads(value) if path in self._texts else value for path, value in values.items()}

    def as_in_column(self, path: str, value: Any) -> Any:
        """Return a value of a parameter as the column of the parameter has it."""
        return value_text(value) if path in self._texts else value

    @property
    def metrics(self) -> list[str]:
        """Names of the columns that are metrics."""
        return [name for name in self.columns if name not in _TYPES and not name.startswith(PREFIX)]


def write_table(
    folder: Path, study: Study, rows: Sequence[tuple[PlannedRun, Finished]], making: dict[str, str]
) -> Path:
    """
    Write the table of a sweep, completely or not at all.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    study : Study
        The study of the sweep.
    rows : sequence of (PlannedRun, Finished)
        In the study's order.
    making : dict
        How it was made: texts by name; stored in the file.

    """
    columns = {name: pa.array(values) for name, values in _columns(study, rows).items()}
    texts = [path for path in study.parameters if not _is_one_type([r.parameters[path] for r, _ in rows])]
    table = pa.table(columns)
    about: dict[str, Any] = {"study": dump(study), "making": making, "texts": texts}
    about[_CHECKSUM] = _checksum(table, about)
    table = table.replace_schema_metadata({_ABOUT: json.dumps(about, allow_nan=False).encode()})
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
        If there is none, or it is not the table of a sweep.

    """
    path = folder / TABLE_FILE
    try:
        table = _read(path)
        about = json.loads((table.schema.metadata or {})[_ABOUT])
        if set(about) != _KEYS_OF_OLD_TABLES and about.pop(_CHECKSUM) != _checksum(table, about):
            raise ValueError("its checksum is wrong")
        study = study_from_plain(about["study"])
        _check(table, study, about)
        return SweepTable(study, about["making"], table.to_pydict(), frozenset(about["texts"]))
    except OSError as error:
        raise ResultsError(f"{path}: cannot be read ({error.strerror or one_line(error)})") from None
    except (pa.ArrowException, LookupError, ValueError, TypeError, RecursionError, ConfigError) as error:
        raise ResultsError(f"{path}: not the table of a sweep ({one_line(error)})") from None


def _read(path: Path) -> pa.Table:
    """Return a table whose checksums are verified; its size in memory is bounded."""
    if not path.is_file():
        raise FileNotFoundError(errno.ENOENT, "no such table")
    with pq.ParquetFile(path, page_checksum_verification=True) as file:
        if file.metadata.num_rows > MAX_RUNS:
            raise ValueError(f"{file.metadata.num_rows} rows; allowed: up to {MAX_RUNS}")
        batches, n_bytes = [], 0
        for batch in file.iter_batches(batch_size=_ROWS_AT_ONCE):
            batches.append(batch)
            n_bytes += batch.nbytes
            if n_bytes > _MOST_BYTES:
                raise ValueError(f"it unpacks to more than {_MOST_BYTES} bytes")
        return pa.Table.from_batches(batches, file.schema_arrow)


def _checksum(table: pa.Table, about: dict[str, Any]) -> str:
    """
    Return a checksum of all columns but those of the wall clock, so that equal sweeps give equal tables.
    """
    columns = table.drop_columns(list(WALL_CLOCK_COLUMNS)).to_pydict()
    return hashlib.sha256(json.dumps([about, columns], sort_keys=True).encode()).hexdigest()


def _check(table: pa.Table, study: Study, about: dict[str, Any]) -> None:
    """Raise ValueError or TypeError if the content is not what `write_table` writes."""
    types = {field.name: field.type for field in table.schema}
    if not len(table):
        raise ValueError("no rows")
    if len(types) != len(table.schema):
        raise ValueError("two columns have one name")
    for name, is_right in _TYPES.items():
        if not is_right(types[name]):
            raise TypeError(f"column {name}: {types[name]} is the wrong type")
        if name not in WALL_CLOCK_COLUMNS and table[name].null_count:
            raise ValueError(f"column {name}: a value is missing")
    for name, found in types.items():
        if not any(is_scalar(found) for is_scalar in _SCALARS):
            raise TypeError(f"column {name}: {found} is not a number, a truth value or a text")
        if not name.startswith(PREFIX) and not name.isidentifier():
            raise ValueError(f"column {name!r}: not the name of a metric")
    if strange := set(table["status"].to_pylist()) - {DONE, FAILED}:
        raise ValueError(f"column status: {sorted(strange)[0]!r} is not a status")
    for path in about["texts"]:
        for text in table[PREFIX + path].unique().to_pylist():
            json.loads(text)
    if missing := [path for path in study.parameters if PREFIX + path not in types]:
        raise ValueError(f"column {PREFIX}{missing[0]}: missing")
    if not all(isinstance(word, str) for pair in about["making"].items() for word in pair):
        raise TypeError("making: not texts by name")


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
    """
    Return values for Parquet: if they are not all numbers, all truth values or all texts, each becomes text.
    """
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
