"""
Finished runs on disk, one small file each, so that a sweep that is killed loses only what was in flight.

``parts/<source version>/<key>.json`` appears whole or not at all.
"""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
from pathlib import Path

from auv_bringup.run_key import source_version
from auv_bringup.sweeps.worker import Finished

_SUFFIX = ".unfinished"


class Parts:
    """The finished runs of this source in one folder."""

    def __init__(self, folder: Path) -> None:
        self._all = folder
        self._folder = folder / source_version()
        self._folder.mkdir(parents=True, exist_ok=True)

    def get(self, key: str) -> Finished | None:
        """Return what came of a run, None where it is not there."""
        try:
            return Finished(**json.loads((self._folder / f"{key}.json").read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            return None

    def put(self, key: str, finished: Finished) -> None:
        """Keep what came of a run."""
        unfinished = self._folder / f"{key}.{os.getpid()}{_SUFFIX}"
        unfinished.write_text(json.dumps(dataclasses.asdict(finished), allow_nan=False), encoding="utf-8")
        unfinished.rename(self._folder / f"{key}.json")

    def forget_old(self) -> None:
        """Remove runs of another source, and what a killed sweep left half-written."""
        for folder in self._all.iterdir():
            if folder != self._folder:
                shutil.rmtree(folder, ignore_errors=True)
        for path in self._folder.glob(f"*{_SUFFIX}"):
            path.unlink(missing_ok=True)
