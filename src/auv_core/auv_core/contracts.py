"""
Checks that a plugin's object has all members of the `Protocol` in the ``__init__.py`` of its folder.

The classes of this tree inherit their protocol, so that mypy compares them.  A class from another folder
need not.  What it lacks is named in one line when it is made.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Protocol

from auv_core.params import ConfigError
from auv_core.plugins import find_plugin


@cache
def members(contract: type) -> list[str]:
    """Return the member names of a protocol and of those that it extends, sorted."""
    asking = [
        base for base in contract.__mro__ if getattr(base, "_is_protocol", False) and base is not Protocol
    ]
    names = {name for base in asking for name in (*vars(base), *vars(base).get("__annotations__", ()))}
    return sorted(name for name in names if not name.startswith("_"))


def class_of(folder: str, kind: str, name: str) -> Any:
    """
    Return the class `name` of a kind in a plugin folder (import path).

    Raises
    ------
    ConfigError
        If the file of the kind defines no such class.

    """
    module = find_plugin(folder, kind)
    if name not in vars(module):
        raise ConfigError(f"{module.__name__}: no {name}; allowed: a file that defines the class {name}")
    return vars(module)[name]


def fulfilled(made: Any, contract: type) -> Any:
    """
    Return the object of a plugin, if it has all members of its protocol.

    Raises
    ------
    ConfigError
        With the missing names.

    """
    lacking = [name for name in members(contract) if not hasattr(made, name)]
    if lacking:
        raise ConfigError(
            f"{type(made).__module__}: {type(made).__name__} has no {', '.join(lacking)}; "
            f"allowed: a class with all members of {contract.__module__}.{contract.__name__}"
        )
    return made
