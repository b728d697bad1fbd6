"""
One source, two speeds: numeric functions that run as plain Python in a node, and compiled in runs of many
vehicles.

A function that is marked here stays a plain Python function. After `use_compiler`, `fastest` returns its
twin, which Numba has compiled from the same source together with the functions that it calls:

* `inner` marks a function that compiled functions may call, and `inlined` one that becomes part of them, so
  that a loop over many vehicles can use vector instructions;
* `entry` marks one that Python calls, with its Numba signature, so that it is compiled only once.

Related numbers are passed as one NamedTuple, marked as a `record` with the types of its fields. A call from
Python at every tick passes a plain tuple instead, which Numba recognises in half the time, and the compiled
function names its numbers: ``c = Constants(*numbers)``. If possible, a loop makes records of arrays before it
starts, since making one updates reference counts.

An argument of the type ``FUNCTION(...)`` takes another entry: so a compiled loop can call a plugin's
function without being compiled again for every plugin.

Compiled code is kept in the user's cache, under a key that covers the source of the entry and of all
functions that it calls: Numba itself would not notice a change in a called function. With
``NUMBA_DISABLE_JIT=1`` nothing is compiled, and all results are the same.
"""

from __future__ import annotations

import gc
import hashlib
import inspect
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
R = TypeVar("R", bound=type[tuple[Any, ...]])

_MOST_KEPT = 200
_inner: set[Callable[..., Any]] = set()
_registered: set[Callable[..., Any]] = set()
_inlined: set[Callable[..., Any]] = set()
_makes_no_array: set[Callable[..., Any]] = set()
_signatures: dict[Callable[..., Any], str] = {}
_records: dict[str, tuple[type[tuple[Any, ...]], str]] = {}
_is_on = False
_tell: Callable[[str], None] | None = None


def inner(function: F) -> F:
    """Mark a function that compiled functions call; it must be defined in a module, not in a function."""
    _inner.add(function)
    return function


def inlined(function: F) -> F:
    """Mark an `inner` function as part of its callers: for loops over many vehicles; slow to compile."""
    _inlined.add(function)
    return inner(function)


def entry(signature: str, *, allocates: bool = True) -> Callable[[F], F]:
    """
    Mark a function that Python calls, with its Numba signature: ``float64(float64[::1], int64)``.

    A function that makes no array (`allocates` is false) skips reference counting, which costs more than a
    short call.

    ``TUPLE3``, ``TUPLE6`` and so on stand for tuples of that many floats, ``FUNCTION(signature)`` for another
    entry with that signature, and the name of a `record` for that record.
    """

    def mark(function: F) -> F:
        _signatures[function] = signature
        if not allocates:
            _makes_no_array.add(function)
        return inner(function)

    return mark


def record(types_of_fields: str) -> Callable[[R], R]:
    """
    Mark a NamedTuple as an argument of entries, with the Numba types of its fields.

    Numba converts no field: an integer in the place of a float is refused.
    """

    def mark(fields: R) -> R:
        known = _records.get(fields.__name__)
        if known is not None and known[0].__module__ != fields.__module__:
            raise ValueError(
                f"record: {fields.__name__!r} is not allowed; allowed: a name that no other record has"
            )
        _records[fields.__name__] = (fields, types_of_fields)
        return fields

    return mark


@cache
def specialised(function: F, **names: Callable[..., Any]) -> F:
    """
    Return a copy of an entry in which the given global names refer to other functions.

    This puts a plugin's function into a compiled loop: each kind gets its own loop, compiled and kept, and a
    call has no extra cost.
    """
    found = {**function.__globals__, **names}
    copy = FunctionType(function.__code__, found, function.__name__, function.__defaults__)
    copy.__module__, copy.__doc__ = function.__module__, function.__doc__
    return entry(_signatures[function])(copy)  # type: ignore[return-value]


def use_compiler(tell: Callable[[str], None] | None = None) -> None:
    """
    Make `fastest` compile from now on. A node that is started alone does not call this: for one vehicle
    compiling takes longer than it saves.

    Parameters
    ----------
    tell : callable, optional
        Receives one line for the user, once, before code is compiled that is not in the cache.

    """
    global _is_on, _tell
    if tell is not None:
        _tell = tell
    _is_on = not os.environ.get("NUMBA_DISABLE_JIT", "0").strip("0")


def is_compiling() -> bool:
    """Whether `fastest` compiles."""
    return _is_on


def fastest(function: F) -> F:
    """Return the compiled twin of an entry after `use_compiler`, otherwise the entry itself."""
    return _compiled(function) if _is_on else function


@cache
def _compiled(function: Callable[..., Any]) -> Any:
    numba = _numba()
    used = _used(function)
    for other in used - _registered - {function}:
        numba.extending.register_jitable(forceinline=other in _inlined)(other)
        _registered.add(other)
    folder = _cache_folder(_version(used))
    if folder is None or not any(folder.iterdir()):
        _say_that_it_takes_a_while()
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    signature = _signature(_signatures[function])
    counts = {"_nrt": False} if function in _makes_no_array else {}
    return numba.njit(signature, cache=folder is not None, error_model="numpy", **counts)(function)


@cache
def _numba() -> Any:
    """
    Import Numba and return it; its objects are frozen, so that the garbage collector does not visit a
    hundred thousand of them during a run. What Numba imports only at a first call is imported here: in flight
    it would take longer than a tick.
    """
    import numba.core.boxing
    import numba.core.runtime.context
    import numba.extending

    gc.freeze()
    return numba


def _say_that_it_takes_a_while() -> None:
    global _tell
    if _tell is not None and _is_on:
        _tell("compiling the numeric code for the first time; this takes about ten seconds")
        _tell = None


def _signature(text: str) -> Any:
    """Return a signature text as a Numba signature."""
    from numba import types

    names = {f"TUPLE{n}": types.UniTuple(types.float64, n) for n in range(2, 64)}
    names["FUNCTION"] = types.FunctionType
    for name in _records_in(text):
        fields, types_of_fields = _records[name]
        names[name] = types.BaseTuple.from_types(_signature(f"({types_of_fields},)"), fields)
    return eval(text, {**vars(types), **names})  # noqa: S307  text of our own source


def _records_in(text: str) -> list[str]:
    """Return the names of the records that a signature mentions, directly or in another record."""
    named = set(re.findall(r"\w+", text)) & _records.keys()
    return sorted(named.union(*(_records_in(_records[name][1]) for name in named)))


def _used(function: Callable[..., Any]) -> set[Callable[..., Any]]:
    """Return a function with all marked functions that it calls, directly or not."""
    used: set[Callable[..., Any]] = set()
    waiting = [function]
    while waiting:
        current = waiting.pop()
        used.add(current)
        named = (current.__globals__.get(name) for name in current.__code__.co_names)
        waiting += [other for other in named if inspect.isfunction(other) and other in _inner - used]
    return used


def _version(used: Iterable[Callable[..., Any]]) -> str:
    """Return a hash of the source of functions and of the constants that they use."""
    digest = hashlib.sha256(sys.version.encode())
    for function in sorted(used, key=lambda f: (f.__module__, f.__qualname__)):
        digest.update(inspect.getsource(function).encode())
        for name in _records_in(_signatures.get(function, "")):
            fields, types_of_fields = _records[name]
            digest.update(f"{name}={fields._fields}: {types_of_fields}".encode())  # type: ignore[attr-defined]
        for name in function.__code__.co_names:
            value = function.__globals__.get(name)
            if isinstance(value, (bool, int, float, tuple)):
                digest.update(f"{name}={value!r}".encode())
            elif isinstance(value, type) and hasattr(value, "_fields"):
                digest.update(f"{name}={value._fields!r}".encode())
    return digest.hexdigest()[:20]


def _cache_folder(version: str) -> Path | None:
    """Return the cache folder for code compiled from this source, None if it cannot be written."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(home) / "shoal" / version
    try:
        folder.mkdir(parents=True, exist_ok=True)
        folder.touch()
        for old in sorted(folder.parent.iterdir(), key=lambda path: path.stat().st_mtime)[:-_MOST_KEPT]:
            shutil.rmtree(old, ignore_errors=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None
