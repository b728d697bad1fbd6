"""
The name of a run, made from everything that its numbers follow from.

That is the resolved scenario, the source that runs depend on, and the versions of Python and its numerical
packages: what is kept under a key is what a new run would give.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import importlib.util
import os
import platform
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from auv_core.plugins import PLUGINS_VARIABLE
from auv_experiment.scenario.loading import scenario_to_json

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_LIBRARIES = ("auv_core", "auv_sim", "auv_control", "auv_flocking")
_ENTRANCES = (
    "auv_experiment.inprocess.sampled",
    "auv_experiment.metrics.run",
    "auv_experiment.scenario.loading",
)
_TRACED = ("auv_core", "auv_experiment")
_NO_SOURCE = {"cli", "figures", "laws", "machine", "nodes", "scenarios"}
_PACKAGES = ("numpy", "scipy", "numba", "scikit-fuzzy")


def run_key(scenario: Scenario) -> str:
    """Return 20 hexadecimal digits that stand for a run of the resolved scenario."""
    text = f"{source_version()}\n{scenario_to_json(scenario)}"
    return hashlib.sha256(text.encode()).hexdigest()[:20]


@cache
def source_version() -> str:
    """
    Return 20 hexadecimal digits that stand for the source and the packages that runs depend on.

    That is all of the libraries and plugins but their nodes and commands, and what the run itself imports of
    auv_experiment and auv_core; scenario files are not in it, since the resolved scenario counts by itself.
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
    """Return the files of `_TRACED` that these import, they included; imports in functions count, too."""
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
    """Return the file of a module of `_TRACED`, None where the name is something else."""
    package, *rest = module.split(".")
    if package not in _TRACED or not rest:
        return None
    path = _folder(package).joinpath(*rest).with_suffix(".py")
    return path if path.is_file() else None


def _folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise ImportError(f"{package} cannot be found")
    return Path(spec.origin).parent
