"""
One source, two speeds: numeric functions that run as plain Python in a node and compiled in a run of many.

A function that is marked here stays the plain Python function that it is.  Where `use_compiler` was called,
`fastest` gives its twin that Numba has compiled from the same source, and what it calls is compiled with it:

* `inner` marks a function that compiled functions may call, and `inlined` one that becomes part of them, so
  that a loop over many vehicles can be turned into vector instructions;
* `entry` marks one that Python calls, with its Numba signature, so that it is compiled once and for all.

Numbers that belong together go in as one NamedTuple, marked as a `record` with the types of its fields.  A
call from Python that happens at every tick hands over a plain tuple instead, which Numba recognises in half
the time, and the compiled function names its numbers: ``c = Constants(*numbers)``.  A loop makes a record of
arrays before it begins where it can: making one counts who holds its arrays.

An argument of the type ``FUNCTION(...)`` takes another entry: so a plugin's function goes into a compiled
loop without that loop being compiled again for every plugin.

What was compiled is kept in the user's cache, under a name that stands for the source of the entry and of
all that it calls: Numba by itself would not see a change in what a kept function calls.  With
``NUMBA_DISABLE_JIT=1`` nothing is compiled, and everything gives the same numbers.
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
    Mark a function that Python calls, with its signature in Numba's words: ``float64(float64[::1], int64)``.

    One that makes no array (`allocates`) need not count who holds its arguments, which costs more than a
    short call.

    ``TUPLE3``, ``TUPLE6`` and so on stand for tuples of so many floats, ``FUNCTION(signature)`` for another
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
    Mark a NamedTuple as an argument of entries, with the types of its fields in Numba's words.

    Numba converts no field: an integer in the place of a float is refused.
    """

    def mark(fields: R) -> R:
        known = _records.get(fields.__name__)
        if known is not None and known[0].__module__ != fields.__module__:
            raise ValueError(f"record: {fields.__name__!r} is not allowed; allowed: a name that no other has")
        _records[fields.__name__] = (fields, types_of_fields)
        return fields

    return mark


@cache
def specialised(function: F, **names: Callable[..., Any]) -> F:
    """
    Return a copy of an entry that finds other functions under the global names given.

    So a plugin's function comes into a compiled loop: each kind gets a loop of its own, compiled and kept,
    and a call costs no more for it.
    """
    found = {**function.__globals__, **names}
    copy = FunctionType(function.__code__, found, function.__name__, function.__defaults__)
    copy.__module__, copy.__doc__ = function.__module__, function.__doc__
    return entry(_signatures[function])(copy)  # type: ignore[return-value]


def use_compiler(tell: Callable[[str], None] | None = None) -> None:
    """
    From now on `fastest` compiles. A node that is started by itself does not call this: one vehicle would
    wait longer than it gains.

    Parameters
    ----------
    tell : callable, optional
        Told, once, in a line for the user, when something is about to be compiled that is not kept yet.

    """
    global _is_on, _tell
    if tell is not None:
        _tell = tell
    _is_on = not os.environ.get("NUMBA_DISABLE_JIT", "0").strip("0")


def is_compiling() -> bool:
    """Whether `fastest` compiles."""
    return _is_on


def fastest(function: F) -> F:
    """Return the compiled twin of an entry where `use_compiler` was called, else the entry itself."""
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
    Return Numba, imported; its hundred thousand objects stay, so the garbage collector need not visit them
    again and again during a run.
    """
    import numba.extending

    gc.freeze()
    return numba


def _say_that_it_takes_a_while() -> None:
    global _tell
    if _tell is not None and _is_on:
        _tell("compiling the numeric code, once; this takes some ten seconds and is kept")
        _tell = None


def _signature(text: str) -> Any:
    """Return a signature in words as Numba has it."""
    from numba import types

    names = {f"TUPLE{n}": types.UniTuple(types.float64, n) for n in range(2, 40)}
    names["FUNCTION"] = types.FunctionType
    for name in _records_in(text):
        fields, types_of_fields = _records[name]
        names[name] = types.BaseTuple.from_types(_signature(f"({types_of_fields},)"), fields)
    return eval(text, {**vars(types), **names})  # noqa: S307  words of our own source


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
    """Return digits that stand for the source of functions and for the constants that they look at."""
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
    """Return where what was compiled from this source is kept, None where nothing can be written."""
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
