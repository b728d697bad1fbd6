"""
Runs on disk, each under a key that covers everything that determines it.

``runs/<key>/`` holds scenario.yaml (resolved), recording.npz (optional), metrics.json and run.json. The key
is that of `auv_experiment.run_key`: a new run with this key would give the same result.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_core.machine.kept_json import KeptError, file_checksum, read_kept, remove, write_kept
from auv_core.machine.whole_files import WriteError, write_error, write_text
from auv_experiment import results, run_key
from auv_experiment.inprocess.evaluated_run import effort
from auv_experiment.recording import Recording, RecordingError
from auv_experiment.scenario.loading import load_scenario, scenario_to_yaml
from auv_thesis.items import RunSpec

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_RUN_FILE = "run.json"
_CHECKSUMS = "checksums"
_SUFFIX = ".unfinished"


@dataclass(frozen=True, eq=False)
class ResolvedRun:
    """A resolved run: its spec, its scenario, and the name of its folder."""

    spec: RunSpec
    scenario: Scenario
    key: str

    @property
    def cost(self) -> float:
        """Expected effort, in evaluations of a law."""
        return effort(self.scenario)


def resolve_run(spec: RunSpec) -> ResolvedRun:
    """Resolve a run; raise ConfigError with one line if the scenario or an override is not allowed."""
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    return ResolvedRun(spec, scenario, run_key.run_key(scenario))


class Store:
    """The finished runs in one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def has(self, run: ResolvedRun) -> bool:
        """
        Return whether the run is kept completely, with its recording if that is needed.

        Raises
        ------
        KeptError
            If the run is kept, but one of its files is not what `put` wrote.

        """
        folder = self.folder / run.key
        try:
            checksums = read_kept(folder / _RUN_FILE, run.key).get(_CHECKSUMS, {})
        except FileNotFoundError:
            return False
        for name, expected in checksums.items():
            path = folder / name
            if not path.is_file() or file_checksum(path) != expected:
                raise KeptError(f"the checksum of {name} is wrong")
        return not run.spec.keep_recording or results.RECORDING_FILE in checksums

    def put(
        self, run: ResolvedRun, recording: Recording, metrics_json: str, *, wall_s: float, cpu_s: float
    ) -> None:
        """
        Keep a finished run and its wall and processor time, completely or not at all.

        Raises
        ------
        WriteError
            If it cannot be written, as on a full disk.

        """
        folder = self.folder / run.key
        unfinished = self.folder / f"{run.key}.{os.getpid()}{_SUFFIX}"
        shutil.rmtree(unfinished, ignore_errors=True)
        try:
            unfinished.mkdir(parents=True)
            write_text(unfinished / results.SCENARIO_FILE, scenario_to_yaml(run.scenario))
            write_text(unfinished / results.METRICS_FILE, metrics_json)
            if run.spec.keep_recording:
                recording.save(unfinished / results.RECORDING_FILE)
            known = {
                "run": str(run.spec),
                "wall_s": wall_s,
                "cpu_s": cpu_s,
                "source": run_key.source_version(),
                _CHECKSUMS: {path.name: file_checksum(path) for path in unfinished.iterdir()},
            }
            write_kept(unfinished / _RUN_FILE, run.key, known)
            remove(folder)
            unfinished.rename(folder)
        except OSError as error:
            raise error if isinstance(error, WriteError) else write_error(folder, error) from error
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)

    def recording(self, key: str) -> Recording:
        """Return the recording of a kept run; raise RecordingError if it cannot be read."""
        try:
            return Recording.load(self.folder / key / results.RECORDING_FILE)
        except OSError as error:
            raise RecordingError(f"{self.folder / key}: not a recording ({error})") from None

    def metrics(self, key: str) -> dict[str, Any]:
        """Return the metrics of a kept run."""
        text = (self.folder / key / results.METRICS_FILE).read_text(encoding="utf-8")
        metrics: dict[str, Any] = json.loads(text)
        return metrics

    def times_s(self, key: str) -> tuple[float, float] | None:
        """Return the wall and processor time of the run when it was flown (s)."""
        try:
            known = read_kept(self.folder / key / _RUN_FILE, key)
            return float(known["wall_s"]), float(known["cpu_s"])
        except (OSError, LookupError, TypeError, ValueError):
            return None

    def forget_old(self) -> int:
        """Remove runs of another source and remains of interrupted runs; return how many."""
        old = list(self._old())
        for folder in old:
            shutil.rmtree(folder, ignore_errors=True)
        return len(old)

    def _old(self) -> Iterator[Path]:
        for folder in self.folder.iterdir() if self.folder.is_dir() else ():
            if folder.is_dir() and (_is_abandoned(folder) or _is_of_another_source(folder)):
                yield folder


def _is_abandoned(folder: Path) -> bool:
    """Return whether the process that was writing this run has ended."""
    _, _, process = folder.name.removesuffix(_SUFFIX).partition(".")
    return folder.name.endswith(_SUFFIX) and not Path("/proc", process).exists()


def _is_of_another_source(folder: Path) -> bool:
    try:
        known = read_kept(folder / _RUN_FILE, folder.name.partition(".")[0])
    except OSError:
        return False
    except KeptError:
        return True
    return known.get("source") != run_key.source_version()
