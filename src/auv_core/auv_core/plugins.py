"""Plugin folders: a kind is the name of a file, and a new file is all that a new kind takes."""

from __future__ import annotations

import importlib
import pkgutil
import re
from types import ModuleType

_WORD = re.compile(r"[a-z][a-z0-9_]*\Z")


class PluginError(ValueError):
    """No such plugin; the message says which there are."""


def list_plugins(folder: str) -> list[str]:
    """
    Return the kinds of a plugin folder, sorted.

    Parameters
    ----------
    folder : str
        Import path of the folder, for example ``auv_flocking.consensus``.

    """
    package = importlib.import_module(folder)
    return sorted(
        info.name for info in pkgutil.iter_modules(package.__path__) if not info.name.startswith("_")
    )


def find_plugin(folder: str, kind: object) -> ModuleType:
    """
    Return the module of `kind` in the plugin folder.

    Raises
    ------
    PluginError
        When `kind` is not a word that names a file of the folder.

    """
    kinds = list_plugins(folder)
    if not isinstance(kind, str) or not _WORD.match(kind) or kind not in kinds:
        raise PluginError(f"{kind!r} is not allowed; allowed: {', '.join(kinds)}")
    return importlib.import_module(f"{folder}.{kind}")
