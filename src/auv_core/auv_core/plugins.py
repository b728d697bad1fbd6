"""
Plugin folders: a kind is the name of a file, and a new file adds a new kind.

The folders of the packages are searched first, then those in the environment variable ``SHOAL_PLUGINS``
(separated as in ``PATH``): ``<folder>/separation/gentle.py`` is the separation law ``gentle``,
``<folder>/models/presets/kayak.yaml`` the vehicle ``kayak``. Kinds of the packages come first.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
import sys
from pathlib import Path
from types import ModuleType

PLUGINS_VARIABLE = "SHOAL_PLUGINS"

_WORD = re.compile(r"[a-z][a-z0-9_]*\Z")


class PluginError(ValueError):
    """Raised for an unknown plugin; the message lists the known ones."""


def list_plugins(folder: str) -> list[str]:
    """
    Return the kinds of a plugin folder, sorted.

    Parameters
    ----------
    folder : str
        Import path of the folder, for example ``auv_flocking.consensus``.

    """
    return sorted(
        info.name
        for info in pkgutil.iter_modules([str(place) for place in plugin_places(folder)])
        if not info.name.startswith("_")
    )


def plugin_places(folder: str) -> list[Path]:
    """Return the directories of a plugin folder, the package's own first, and make them importable."""
    package = importlib.import_module(folder)
    name = folder.rpartition(".")[2]
    for root in os.environ.get(PLUGINS_VARIABLE, "").split(os.pathsep):
        place = str(Path(root, name).absolute())
        if root and place not in package.__path__ and Path(place).is_dir():
            package.__path__.append(place)
    return [Path(place) for place in package.__path__]


def own_files(folder: str) -> list[Path]:
    """Return the files that ``SHOAL_PLUGINS`` adds to a plugin folder, and let Python import them."""
    plugin_places(folder)
    name = folder.rpartition(".")[2]
    roots = [root for root in os.environ.get(PLUGINS_VARIABLE, "").split(os.pathsep) if root]
    found = (path for root in roots for path in sorted(Path(root, name).absolute().glob("*.py")))
    return [path for path in found if not path.stem.startswith("_")]


def find_plugin(folder: str, kind: object) -> ModuleType:
    """
    Return the module of `kind` in the plugin folder.

    Raises
    ------
    PluginError
        If `kind` is not the name of a file of the folder.

    """
    if isinstance(kind, str) and _WORD.match(kind):
        loaded = sys.modules.get(f"{folder}.{kind}")
        if loaded is not None:
            return loaded
    kinds = list_plugins(folder)
    if not isinstance(kind, str) or not _WORD.match(kind) or kind not in kinds:
        raise PluginError(f"{kind!r} is not allowed; allowed: {', '.join(kinds)}")
    return importlib.import_module(f"{folder}.{kind}")
