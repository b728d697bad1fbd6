"""
Runs on disk, each under a name that stands for everything it follows from.

``runs/<hash>/`` holds scenario.yaml (resolved), recording.npz (where it is wanted), metrics.json and
run.json. The hash is taken over the resolved scenario, the source that runs depend on, and the versions of
Python and its numerical packages: what is found under it is what a new run would give.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import importlib.util
import json
import os
import platform
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_bringup import results
from auv_bringup.recording import Recording, RecordingError
from auv_bringup.reproduction import RunSpec
from auv_bringup.scenario import load_scenario, scenario_to_yaml
from auv_core.plugins import PLUGINS_VARIABLE

if TYPE_CHECKING:
    from auv_bringup.scenario import Scenario

_RUN_FILE = "run.json"
_SUFFIX = ".unfinished"
_LIBRARIES = ("auv_core", "auv_sim", "auv_control", "auv_flocking")
_ENTRANCES = ("auv_bringup.experiment", "auv_bringup.metrics", "auv_bringup.scenario")
_NO_SOURCE = {"nodes", "reproduction", "scenarios"}
_PACKAGES = ("numpy", "scipy", "numba", "scikit-fuzzy")


@dataclass(frozen=True, eq=False)
class PlannedRun:
    """A run resolved: its spec, its scenario, and the name of its folder."""

    spec: RunSpec
    scenario: Scenario
    key: str

    @property
    def cost(self) -> float:
        """Expected effort, in evaluations of a law."""
        s, n = self.scenario, len(self.scenario.vehicles)
        if s.sampling == "continuous":
            return n * 4.0 * s.duration_s / s.dt_s
        return n * (s.duration_s / s.dt_s + (8.0 + 4.0 * n) * s.duration_s / s.period_s)


def plan_run(spec: RunSpec) -> PlannedRun:
    """Resolve a run; raise ConfigError with one line where the scenario or an override is not allowed."""
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    digest = hashlib.sha256(f"{source_version()}\n{scenario_to_yaml(scenario)}".encode())
    return PlannedRun(spec, scenario, digest.hexdigest()[:20])


class Store:
    """The finished runs in one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def has(self, run: PlannedRun) -> bool:
        """Tell whether the run is there, complete, with its recording if that is wanted."""
        folder = self.folder / run.key
        has_recording = not run.spec.keep_recording or (folder / results.RECORDING_FILE).is_file()
        return (folder / _RUN_FILE).is_file() and has_recording

    def put(
        self, run: PlannedRun, recording: Recording, metrics_json: str, *, wall_s: float, cpu_s: float
    ) -> None:
        """
        Keep what is wanted of a finished run, and the wall and processor time that it took: all or nothing.
        """
        unfinished = self.folder / f"{run.key}.{os.getpid()}{_SUFFIX}"
        shutil.rmtree(unfinished, ignore_errors=True)
        unfinished.mkdir(parents=True)
        (unfinished / results.SCENARIO_FILE).write_text(scenario_to_yaml(run.scenario), encoding="utf-8")
        (unfinished / results.METRICS_FILE).write_text(metrics_json, encoding="utf-8")
        if run.spec.keep_recording:
            recording.save(unfinished / results.RECORDING_FILE)
        known = {"run": str(run.spec), "wall_s": wall_s, "cpu_s": cpu_s, "source": source_version()}
        results.write_json(unfinished / _RUN_FILE, known)
        shutil.rmtree(self.folder / run.key, ignore_errors=True)
        unfinished.rename(self.folder / run.key)

    def recording(self, key: str) -> Recording:
        """Return the recording of a run that is there; raise RecordingError where it cannot be read."""
        try:
            return Recording.load(self.folder / key / results.RECORDING_FILE)
        except OSError as error:
            raise RecordingError(f"{self.folder / key}: not a recording ({error})") from None

    def metrics(self, key: str) -> dict[str, Any]:
        """Return the metrics of a run that is there."""
        text = (self.folder / key / results.METRICS_FILE).read_text(encoding="utf-8")
        metrics: dict[str, Any] = json.loads(text)
        return metrics

    def times_s(self, key: str) -> tuple[float, float] | None:
        """Return the wall and the processor time that the run took when it was flown (s)."""
        known = results.read_json(self.folder / key / _RUN_FILE)
        try:
            return float(known["wall_s"]), float(known["cpu_s"])
        except (KeyError, TypeError, ValueError):
            return None

    def forget_old(self) -> int:
        """Remove runs of another source, and what runs that were interrupted left; return how many."""
        old = list(self._old())
        for folder in old:
            shutil.rmtree(folder, ignore_errors=True)
        return len(old)

    def _old(self) -> Iterator[Path]:
        for folder in self.folder.iterdir() if self.folder.is_dir() else ():
            source = results.read_json(folder / _RUN_FILE).get("source", source_version())
            if source != source_version() or _is_abandoned(folder):
                yield folder


def _is_abandoned(folder: Path) -> bool:
    """Tell whether the process that was writing this run is gone."""
    _, _, process = folder.name.removesuffix(_SUFFIX).partition(".")
    return folder.name.endswith(_SUFFIX) and not Path("/proc", process).exists()


@cache
def source_version() -> str:
    """
    Return 20 hexadecimal digits that stand for the source and the packages that runs depend on.

    That is all of the libraries and plugins but their nodes, and of auv_bringup what the run itself imports;
    scenario files are not in it, since the resolved scenario counts by itself.
    """
    digest = hashlib.sha256(platform.python_version().encode())
    for package in _PACKAGES:
        digest.update(f"{package} {_version(package)}\n".encode())
    for path in sorted(_source_files()):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:20]


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "none"


def _source_files() -> set[Path]:
    files = _imported(_ENTRANCES)
    plugins = [Path(text) for text in os.environ.get(PLUGINS_VARIABLE, "").split(os.pathsep) if text]
    for folder in (*(_folder(library) for library in _LIBRARIES), *plugins):
        found = (path for pattern in ("*.py", "*.yaml") for path in folder.rglob(pattern))
        files |= {path for path in found if not _NO_SOURCE & set(path.relative_to(folder).parts)}
    return files


def _imported(entrances: tuple[str, ...]) -> set[Path]:
    """Return the files of auv_bringup that these import, they included; imports in functions count, too."""
    found: set[Path] = set()
    waiting = list(entrances)
    while waiting:
        path = _file(waiting.pop())
        if path is None or path in found:
            continue
        found.add(path)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                waiting += [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                waiting += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return found


def _file(module: str) -> Path | None:
    """Return the file of a module of auv_bringup, None where the name is something else."""
    package, *rest = module.split(".")
    if package != "auv_bringup" or not rest:
        return None
    path = _folder(package).joinpath(*rest).with_suffix(".py")
    return path if path.is_file() else None


def _folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise ImportError(f"{package} cannot be found")
    return Path(spec.origin).parent
