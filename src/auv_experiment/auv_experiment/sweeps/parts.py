"""
Finished runs on disk, one small file each, so that a killed sweep loses only the runs in flight.

``parts/<source version>/<key>.json`` is written completely or not at all, and holds its own checksum.
"""

from __future__ import annotations

import dataclasses
import math
import shutil
from pathlib import Path
from typing import Any

from auv_core.machine.kept_json import KeptError, read_kept, write_kept
from auv_experiment.results import make_folder
from auv_experiment.run_key import source_version
from auv_experiment.sweeps.worker import Finished

_LARGEST_INT = 2**63


class Parts:
    """The finished runs of this source in one folder; raises ResultsError if that cannot be made."""

    def __init__(self, folder: Path) -> None:
        self._all = folder
        self._folder = folder / source_version()
        make_folder(self._folder)

    def path(self, key: str) -> Path:
        """Return the file of a run."""
        return self._folder / f"{key}.json"

    def get(self, key: str) -> Finished | None:
        """Return the result of a run, None if it is not kept; raise KeptError if its file is damaged."""
        try:
            return _finished(read_kept(self.path(key), key))
        except FileNotFoundError:
            return None

    def put(self, key: str, finished: Finished) -> None:
        """Keep the result of a run; raise WriteError if it cannot be written."""
        write_kept(self.path(key), key, dataclasses.asdict(finished))

    def forget_old(self) -> None:
        """Remove runs of another source, and half-written files of a killed sweep."""
        for folder in self._all.iterdir():
            if folder != self._folder:
                shutil.rmtree(folder, ignore_errors=True)
        for path in self._folder.glob(".*.part.json"):
            process = path.name.split(".")[-3]
            if not Path("/proc", process).exists():
                path.unlink(missing_ok=True)


def _finished(known: dict[str, Any]) -> Finished:
    """Return a finished run from plain data; raise KeptError if a field has the wrong type."""
    if set(known) != {field.name for field in dataclasses.fields(Finished)}:
        raise KeptError("not a finished run")
    finished = Finished(**known)
    metrics = finished.metrics
    holds = {
        "metrics": isinstance(metrics, dict) and all(map(_is_scalar, metrics.values())),
        "error": isinstance(finished.error, str),
        "traceback": isinstance(finished.traceback, str),
        "is_lasting": isinstance(finished.is_lasting, bool),
        "wall_s": _is_time(finished.wall_s),
        "cpu_s": _is_time(finished.cpu_s),
    }
    for name, it_holds in holds.items():
        if not it_holds:
            raise KeptError(f"{name} has the wrong type")
    return finished


def _is_scalar(value: object) -> bool:
    if isinstance(value, int):
        return abs(value) < _LARGEST_INT
    return value is None or isinstance(value, str) or (isinstance(value, float) and math.isfinite(value))


def _is_time(value: object) -> bool:
    return value is None or (isinstance(value, float) and math.isfinite(value))
