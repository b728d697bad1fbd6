"""How a page was made: the command, the versions, and every run with its duration."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from auv_experiment import results

if TYPE_CHECKING:
    from auv_thesis.runs.runner import Flown

_SHOWN_PACKAGES = ("numpy", "scipy", "numba", "scikit-fuzzy", "matplotlib")


@dataclass(frozen=True)
class MadeRun:
    """One line about a run: its name on a command line, wall and processor time (s), and a remark."""

    name: str
    wall_s: float | None
    cpu_s: float | None
    remark: str


@dataclass(frozen=True)
class Making:
    """How a page was made."""

    command: str
    facts: str
    versions: dict[str, str]
    runs: tuple[MadeRun, ...]


def making_of(command: str, flown: Flown, *, n_workers: int, wall_s: float) -> Making:
    """
    Return how a page was made.

    Parameters
    ----------
    command : str
        Command line.
    flown : Flown
        Its runs.
    n_workers : int
        Number of processes.
    wall_s : float
        Time since the start of the command (s).

    """
    processes = f"{n_workers} process{'es' if n_workers != 1 else ''}"
    keys = {run.key for run in flown.resolved.values()}
    cpu_s = sum(flown.times_s[key][1] for key in keys if key in flown.times_s)
    facts = (
        f"{len(keys)} runs, {cpu_s:.0f} s of processor time; this page took {wall_s:.0f} s in {processes}, "
        f"{len(flown.kept)} runs kept from an earlier call"
    )
    return Making(command, facts, _versions(), tuple(_runs(flown)))


def _runs(flown: Flown) -> list[MadeRun]:
    runs: dict[str, MadeRun] = {}
    for spec, resolved in flown.resolved.items():
        remark = "kept from an earlier call" if resolved.key in flown.kept else ""
        if spec in flown.failed:
            remark = f"failed: {flown.failed[spec].line}"
        wall_s, cpu_s = flown.times_s.get(resolved.key, (None, None))
        runs.setdefault(resolved.key, MadeRun(str(spec), wall_s, cpu_s, remark))
    unresolved = [
        MadeRun(str(spec), None, None, f"failed: {failure.line}")
        for spec, failure in flown.failed.items()
        if spec not in flown.resolved
    ]
    return sorted([*runs.values(), *unresolved], key=lambda run: run.name)


def _versions() -> dict[str, str]:
    packages = results.package_versions()
    versions = {"Python": platform.python_version()}
    versions.update({name: packages[name] for name in _SHOWN_PACKAGES if name in packages})
    versions["system"] = platform.platform()
    git = results.git_state(Path(__file__).resolve())
    if git:
        changed = ", with local changes" if git.get("has_local_changes") else ""
        versions["revision"] = f"{git.get('revision')}{changed}"
    return versions
