"""
The results folder of a run: one folder per run, named after its scenario, never overwritten.

``results/<scenario>-<seed>-<mode>[-<hash of the overrides>][-2, -3, ...]/`` holds

    scenario.yaml     the resolved scenario: loading it gives the same run again
    provenance.json   seed, overrides, versions of every package, git revision, and how the flight ended
    bag/              the recorder's bag, or recording.npz for a run in one process
    logs/             one file per node, and the parameters that it was started with
    metrics.json, figures/*, report.html
"""

from __future__ import annotations

import datetime
import hashlib
import importlib.metadata
import json
import math
import platform
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_core.machine.whole_files import reserve, write_reserved, write_text
from auv_experiment.figures.formats import PAGE_FORMAT
from auv_experiment.scenario.strict_yaml import parse_yaml

if TYPE_CHECKING:
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario

BAG = "bag"
FIGURES = "figures"
LOGS = "logs"
METRICS_FILE = "metrics.json"
PROVENANCE_FILE = "provenance.json"
RECORDING_FILE = "recording.npz"
REPORT_FILE = "report.html"
SCENARIO_FILE = "scenario.yaml"

_GIT_TIMEOUT_S = 5.0
_ENDING_BYTES = 32_768
"""Space for the end of a flight: a few numbers, a reason, and lines about foreign publishers."""


class ResultsError(ValueError):
    """Raised if a results folder cannot be made or read; the message is one line for the user."""


def overrides_hash(overrides: Sequence[str], duration_s: float | None = None) -> str:
    """
    Return a hash of the overrides (8 hexadecimal digits), '' without overrides.

    Only the final value of each key matters, not the order of different keys, spaces in a value, or 20
    against 20.0. `duration_s` counts as an override of that key.
    """
    values: dict[str, Any] = {}
    for override in overrides:
        path, _, text = override.partition("=")
        values[path] = _canonical(parse_yaml(text, f"--set {path}"))
    if duration_s is not None:
        values["duration_s"] = _canonical(duration_s)
    if not values:
        return ""
    text = json.dumps(values, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def _canonical(value: Any) -> Any:
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**53:
        return float(value)
    if isinstance(value, list):
        return [_canonical(item) for item in value]
    if isinstance(value, dict):
        return {str(key): _canonical(item) for key, item in value.items()}
    return value


def results_name(scenario: str, seed: int, mode: str, digest: str = "") -> str:
    """Return the name of a run's folder, without the suffix that distinguishes repeated runs."""
    return f"{scenario}-{seed}-{mode}" + (f"-{digest}" if digest else "")


def make_results_dir(parent: Path, name: str) -> Path:
    """
    Make and return a new folder `name` in `parent`; `name`-2, `name`-3, ... if it exists.

    Two runs that start at the same moment never get the same folder.

    Raises
    ------
    ResultsError
        If the folder cannot be made.

    """
    try:
        parent.mkdir(parents=True, exist_ok=True)
        number = 1
        while True:
            folder = parent / (name if number == 1 else f"{name}-{number}")
            try:
                folder.mkdir()
            except FileExistsError:
                number += 1
            else:
                return folder
    except OSError as error:
        raise ResultsError(f"--out {str(parent)!r}: cannot be written ({error.strerror or error})") from None


def make_folder(folder: Path) -> None:
    """Make the folder of `--out` if it does not exist; raise ResultsError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise ResultsError(f"--out {str(folder)!r}: cannot be written ({error.strerror or error})") from None


def provenance(
    scenario: Scenario, *, mode: str, overrides: Sequence[str] = (), duration_s: float | None = None
) -> dict[str, Any]:
    """Return the data, besides the resolved scenario, that are needed to repeat a run."""
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "mode": mode,
        "overrides": list(overrides),
        "duration_s": scenario.duration_s,
        "duration_was_set": duration_s is not None,
        "started_at": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "git": git_state(Path(__file__).resolve()),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": package_versions(),
    }


def package_versions() -> dict[str, str]:
    """Return the version of every installed Python distribution, by name."""
    found = ((d.metadata["Name"], d.version) for d in importlib.metadata.distributions())
    return dict(sorted((str(name), str(version)) for name, version in found if name))


def git_state(file: Path) -> dict[str, Any] | None:
    """
    Return revision and cleanness of the checkout that tracks `file`.

    None if there is no git or no checkout, or if `file` lies in one but is not tracked.
    """
    try:
        _git(file.parent, "ls-files", "--error-unmatch", file.name)
        return {
            "revision": _git(file.parent, "rev-parse", "HEAD").strip(),
            "has_local_changes": bool(
                _git(file.parent, "status", "--porcelain", "--untracked-files=no").strip()
            ),
        }
    except (OSError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        capture_output=True,
        text=True,
        timeout=_GIT_TIMEOUT_S,
        check=True,
    )
    return done.stdout


def write_json(path: Path, data: dict[str, Any]) -> None:
    """Write strict JSON; a number that is not finite becomes null."""
    write_text(path, _json_text(data))


def _json_text(data: dict[str, Any]) -> str:
    plain = {key: None if isinstance(v, float) and not math.isfinite(v) else v for key, v in data.items()}
    return json.dumps(plain, indent=2, allow_nan=False) + "\n"


def write_beginning(folder: Path, record: dict[str, Any], *, has_ending: bool) -> None:
    """Write the provenance of a run; if a flight `has_ending`, reserve space for its end."""
    path = folder / PROVENANCE_FILE
    write_json(path, record)
    if has_ending:
        reserve(path, path.stat().st_size + _ENDING_BYTES)


def write_ending(folder: Path, **ending: Any) -> None:
    """Add the end of a run to its provenance, even on a full disk."""
    path = folder / PROVENANCE_FILE
    write_reserved(path, _json_text({**read_json(path), **ending}))


def read_json(path: Path) -> dict[str, Any]:
    """Return the data that `write_json` wrote; {} if there is no such file or it has other content."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return data if isinstance(data, dict) else {}


def load_recording(
    results_dir: Path, scenario: Scenario, tell: Callable[[str], None] = lambda _: None
) -> Recording:
    """
    Return the recording of a run: `recording.npz` of a run in one process, otherwise its bag.

    Parameters
    ----------
    results_dir : Path
        The run's folder.
    scenario : Scenario
        The scenario of the run.
    tell : callable
        Gets a line about messages of a bag that do not belong to the run.

    Raises
    ------
    ResultsError
        If there is neither, or it cannot be read.

    """
    from auv_bag.writer import BagError
    from auv_experiment.recording import Recording, RecordingError
    from auv_experiment.recording_from_bag import read_recording

    try:
        if (results_dir / RECORDING_FILE).is_file():
            return Recording.load(results_dir / RECORDING_FILE)
        return read_recording(results_dir / BAG, scenario, tell)
    except (BagError, RecordingError) as error:
        raise ResultsError(f"{results_dir}: nothing to report on: {error}") from None


def write_results(
    results_dir: Path,
    scenario: Scenario,
    recording: Recording,
    *,
    mode: str,
    real_time_factor: float,
    formats: Sequence[str] = (PAGE_FORMAT,),
    on_step: Callable[[str], None] = lambda step: None,
    tell: Callable[[str], None] = lambda line: None,
) -> dict[str, Any]:
    """
    Write metrics, figures and report of a recorded run, and return the metrics.

    Parameters
    ----------
    results_dir : Path
        The run's folder.
    scenario, recording
        The scenario and the recording.
    mode : str
        'lockstep', 'realtime' or 'inprocess'.
    real_time_factor : float
        Simulated seconds per second of wall time during the flight; NaN if unknown.
    formats : sequence of str
        Formats of the figures, as `with_page_format` gives them; empty for a report without figures.
    on_step : callable
        Receives the current step as a short text.
    tell : callable
        Gets a line about each file of own metrics or figures that failed.

    """
    from auv_experiment.metrics.own import failure_warning
    from auv_experiment.metrics.run import compute_metrics, metrics_to_json

    on_step("metrics")
    metrics = compute_metrics(recording, scenario, mode=mode, real_time_factor=real_time_factor)
    write_text(results_dir / METRICS_FILE, metrics_to_json(metrics))
    if warning := failure_warning(metrics):
        tell(warning)

    from auv_experiment.figures import SavedFigures
    from auv_experiment.report.report import write_report

    saved = SavedFigures()
    if formats:
        from auv_experiment.figures.by_law import run_drawers
        from auv_experiment.figures.files import save_figures

        on_step("figures")
        saved = save_figures(run_drawers(recording, scenario), scenario, results_dir / FIGURES, formats)
    for line in saved.failures:
        tell(f"{line}; the figure is left out")
    on_step("report")
    write_report(results_dir, scenario, metrics, saved)
    return metrics
