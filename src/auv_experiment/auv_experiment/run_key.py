"""
The key of a run, computed from everything that determines its numbers.

That is the resolved scenario, the source that runs depend on, and the versions of Python and its numerical
packages. A new run with the same key gives the kept result.
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
    """Return the key of a run of the resolved scenario (20 hexadecimal digits)."""
    text = f"{source_version()}\n{scenario_to_json(scenario)}"
    return hashlib.sha256(text.encode()).hexdigest()[:20]


@cache
def source_version() -> str:
    """
    Return a hash of the source and the packages that runs depend on (20 hexadecimal digits).

    It covers all libraries and plugins except nodes and commands, and the modules of auv_experiment and
    auv_core that a run imports. Scenario files are not included, since the resolved scenario is in the key
    itself.
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
    """
    Return the files of `_TRACED` that these files import, including themselves; imports in functions count,
    too.
    """
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
    """Return the file of a module of `_TRACED`, None for other names."""
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
