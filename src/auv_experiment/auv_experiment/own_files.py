"""
Files of metrics and figures that users add in a folder of ``SHOAL_PLUGINS``.

A file that cannot be used is refused before anything is flown, in one line. A file that fails with a
recording is named in one line, and only its own metrics or its own figure is missing.
"""

from __future__ import annotations

import importlib
import re
import traceback
from copy import copy
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from auv_core.machine.failure import one_line
from auv_core.params import ConfigError
from auv_core.plugins import own_files

if TYPE_CHECKING:
    from auv_experiment.recording import Recording

WORD = re.compile(r"[a-z][a-z0-9_]*\Z")
WORDS = "lower-case letters, digits and underscores, a letter first"


def load_own_files(folder: str) -> dict[str, ModuleType]:
    """
    Return the content of the own files of a plugin folder, by name.

    Parameters
    ----------
    folder : str
        Import path of the folder: ``auv_experiment.metrics`` or ``auv_experiment.figures``.

    Raises
    ------
    ConfigError
        If a file cannot be imported, or its name is not allowed or taken; one line.

    """
    return {path.stem: _load(folder, path) for path in own_files(folder)}


def where(path: Path) -> str:
    """Return the name of an own file in messages: ``metrics/depth.py``."""
    return f"{path.parent.name}/{path.name}"


def failure_line(module: ModuleType, error: Exception) -> str:
    """Return on one line what failed in an own file, and at which of its lines."""
    path = Path(str(module.__file__))
    numbers = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
    ]
    at = f", line {numbers[-1]}" if numbers else ""
    return f"{where(path)}{at}: {one_line(error)}"


def read_only(recording: Recording) -> Recording:
    """Return a recording with the same data and read-only arrays, for an own file."""
    copied = copy(recording)
    for name, value in vars(recording).items():
        if isinstance(value, np.ndarray):
            view = value.view()
            view.flags.writeable = False
            setattr(copied, name, view)
    return copied


def _load(folder: str, path: Path) -> ModuleType:
    if not WORD.match(path.stem):
        raise ConfigError(f"{where(path)}: {path.stem!r} is not allowed; allowed: {WORDS}")
    try:
        module = importlib.import_module(f"{folder}.{path.stem}")
    except Exception as error:
        raise ConfigError(f"{where(path)}: cannot be imported ({one_line(error)})") from error
    if module.__file__ != str(path):
        raise ConfigError(f"{where(path)}: the name is taken by {module.__file__}; allowed: another name")
    return module
