"""
Strict loading of configuration into frozen dataclasses.

A configuration class is a frozen dataclass whose fields are made with :func:`param`.  :func:`load` turns a
plain mapping (from YAML or from ROS parameters) into an instance and refuses, with one line that names the
dotted path, the value and what is allowed: unknown keys, missing keys, wrong types, values out of range,
not-a-number. :func:`dump` is its inverse.

A field of type :class:`Section` chooses a plugin: ``{kind: tdma, params: {...}}`` names the file ``tdma.py``
in the plugin folder of the field, and ``params`` is loaded into that file's ``Params``.
"""

from __future__ import annotations

import dataclasses
import math
import reprlib
import types
import typing
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, TypeVar

from auv_core.plugins import PluginError, find_plugin, list_plugins

T = TypeVar("T")

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60


class ConfigError(ValueError):
    """A configuration value that cannot be used; the message is one line for the user."""


@dataclasses.dataclass(frozen=True)
class Section:
    """A chosen plugin: the file ``kind`` of a plugin folder, with that file's ``Params``."""

    kind: str
    params: Any


def param(
    doc: str,
    *,
    default: Any = dataclasses.MISSING,
    minimum: float | None = None,
    maximum: float | None = None,
    above: float | None = None,
    choices: Sequence[str] | None = None,
    plugins: str | None = None,
) -> Any:
    """
    Return a dataclass field with its meaning and its allowed values.

    Parameters
    ----------
    doc : str
        Meaning, with unit and frame; also the description of the ROS parameter.
    default : any
        Value when the key is absent; without it the key is required.
    minimum, maximum : float
        Inclusive bounds of a number, or of every item of a sequence.
    above : float
        Exclusive lower bound.
    choices : sequence of str
        Allowed words.
    plugins : str
        Import path of the plugin folder of a `Section` field.

    """
    metadata = {
        "doc": doc,
        "minimum": minimum,
        "maximum": maximum,
        "above": above,
        "choices": tuple(choices) if choices else None,
        "plugins": plugins,
    }
    return dataclasses.field(default=default, metadata=metadata)


def same(owner: type, name: str, **changes: Any) -> Any:
    """
    Return the field `name` of another configuration, so that a value is described once.

    Parameters
    ----------
    owner : type
        Dataclass with fields made by `param`.
    name : str
        Name of the field.
    changes : any
        Arguments of `param` that are different here.

    """
    (field,) = [field for field in dataclasses.fields(owner) if field.name == name]
    return param(**{"default": field.default, **field.metadata, **changes})


def extended(cls: type[T], *sections: object, **own: Any) -> T:
    """
    Return a configuration from sections of a scenario and what is its own.

    Parameters
    ----------
    cls : type
        Dataclass of the configuration.
    sections : dataclasses
        Each gives the fields that `cls` has too.
    own : any
        The other fields, by name; they count before those of sections.

    """
    names = {field.name for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    taken = {
        field.name: getattr(section, field.name)
        for section in sections
        for field in dataclasses.fields(section)  # type: ignore[arg-type]
        if field.name in names
    }
    return cls(**{**taken, **own})


def load(cls: type[T], raw: object, path: str) -> T:
    """
    Return an instance of the dataclass `cls` from the mapping `raw`.

    Parameters
    ----------
    cls : type
        Frozen dataclass with fields made by `param`.
    raw : mapping
        Plain data, as YAML gives it.
    path : str
        Dotted path of `raw` in its file, for messages.

    Raises
    ------
    ConfigError
        At the first value that is unknown, missing, mistyped or not allowed.

    """
    if not isinstance(raw, Mapping):
        raise ConfigError(
            f"{path}: {shown(raw)} is not allowed; allowed: a mapping with the keys {_keys(cls)}"
        )
    fields = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    unknown = [key for key in raw if key not in fields]
    if unknown:
        raise ConfigError(f"{path}: unknown key {shown(unknown[0])}; allowed: {_keys(cls)}")
    hints = _type_hints(cls)  # type: ignore[arg-type]
    values = {}
    for name, field in fields.items():
        if name in raw:
            values[name] = _value(hints[name], raw[name], f"{path}.{name}", field.metadata)
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ConfigError(f"{path}.{name}: missing; it is {field.metadata.get('doc', 'required')}")
    try:
        return cls(**values)
    except ConfigError:
        raise
    except ValueError as error:
        raise ConfigError(f"{path}.{error}") from None


def dump(value: object) -> Any:
    """Return plain data (mappings, lists, numbers, words) from which `load` makes an equal instance."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: dump(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple | list):
        return [dump(item) for item in value]
    if isinstance(value, dict):
        return {key: dump(item) for key, item in value.items()}
    return value


def item_key(index: int) -> str:
    """Return the name of an item of a list of configurations where there are only names (ROS parameters)."""
    return f"n{index}"


def check_number(value: float, path: str, bounds: Mapping[str, Any], *, is_whole: bool = False) -> None:
    """Raise `ConfigError` when `value` is not finite or lies outside the bounds of a (whole) `param`."""
    low, high, above = bounds.get("minimum"), bounds.get("maximum"), bounds.get("above")
    inside = (
        (low is None or value >= low) and (high is None or value <= high) and (above is None or value > above)
    )
    if not math.isfinite(value) or not inside:
        raise ConfigError(
            f"{path}: {value!r} is not allowed; allowed: {allowed_range(bounds, is_whole=is_whole)}"
        )


def allowed_range(bounds: Mapping[str, Any], *, is_whole: bool = False) -> str:
    """Return the bounds of a `param` as text; those of a whole number with all digits."""
    words = {"minimum": "at least", "above": "above", "maximum": "at most"}
    parts = [
        f"{word} {bounds[key] if is_whole else format(bounds[key], 'g')}"
        for key, word in words.items()
        if bounds.get(key) is not None
    ]
    return ("a whole number" if is_whole else "a finite number") + (
        " " + " and ".join(parts) if parts else ""
    )


def _keys(cls: Any) -> str:
    return "[" + ", ".join(field.name for field in dataclasses.fields(cls)) + "]"


def shown(value: object) -> str:
    """Return `value` for a message: on one line and short, however large it is."""
    try:
        text = _REPR.repr(value)
    except ValueError:
        return "a number too long to print"
    return text if len(text) <= 60 else text[:57] + "..."


@cache
def _type_hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def _value(hint: Any, raw: object, path: str, metadata: Mapping[str, Any]) -> Any:
    origin = typing.get_origin(hint)
    if origin in (typing.Union, types.UnionType):
        if raw is None:
            return None
        hint = next(option for option in typing.get_args(hint) if option is not type(None))
        origin = typing.get_origin(hint)
    if hint is Section:
        return load_section(raw, path, metadata["plugins"])
    if dataclasses.is_dataclass(hint):
        return load(typing.cast(type, hint), raw, path)
    if origin is tuple:
        return _tuple(hint, raw, path, metadata)
    if origin is dict:
        return _mapping(hint, raw, path, metadata)
    if hint is Any:
        return raw
    return _scalar(hint, raw, path, metadata)


def load_section(raw: object, path: str, folder: str) -> Section:
    """Return the `Section` of ``{kind: ..., params: {...}}`` for the plugin folder `folder` (import path)."""
    if not isinstance(raw, Mapping):
        raise ConfigError(
            f"{path}: {shown(raw)} is not allowed; allowed: a mapping with the keys [kind, params]"
        )
    unknown = [key for key in raw if key not in ("kind", "params")]
    if unknown:
        raise ConfigError(f"{path}: unknown key {shown(unknown[0])}; allowed: [kind, params]")
    if "kind" not in raw:
        raise ConfigError(f"{path}.kind: missing; it is the name of a file in {folder}")
    if not isinstance(raw["kind"], str):
        raise ConfigError(
            f"{path}.kind: {shown(raw['kind'])} is not allowed; allowed: {', '.join(list_plugins(folder))}"
        )
    try:
        module = find_plugin(folder, raw["kind"])
    except PluginError as error:
        raise ConfigError(f"{path}.kind: {error}") from None
    if "Params" not in vars(module):
        raise ConfigError(f"{path}.kind: {module.__name__} has no Params; allowed: a file that defines them")
    params = raw.get("params")
    return Section(raw["kind"], load(module.Params, {} if params is None else params, f"{path}.params"))


def _tuple(hint: Any, raw: object, path: str, metadata: Mapping[str, Any]) -> tuple[Any, ...]:
    items = typing.get_args(hint)
    any_length = len(items) == 2 and items[1] is Ellipsis
    wanted = "a list" if any_length else f"a list of {len(items)} numbers"
    if not isinstance(raw, list | tuple) or (not any_length and len(raw) != len(items)):
        raise ConfigError(f"{path}: {shown(raw)} is not allowed; allowed: {wanted}")
    hints = [items[0]] * len(raw) if any_length else list(items)
    return tuple(
        _value(item_hint, item, f"{path}[{index}]", metadata)
        for index, (item_hint, item) in enumerate(zip(hints, raw, strict=True))
    )


def _mapping(hint: Any, raw: object, path: str, metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping of free words to items of one type."""
    if not isinstance(raw, Mapping) or not all(isinstance(key, str) for key in raw):
        raise ConfigError(f"{path}: {shown(raw)} is not allowed; allowed: a mapping with words for keys")
    item = typing.get_args(hint)[1]
    return {key: _value(item, value, f"{path}.{key}", metadata) for key, value in raw.items()}


def _scalar(hint: Any, raw: object, path: str, metadata: Mapping[str, Any]) -> Any:
    if hint is bool:
        if isinstance(raw, bool):
            return raw
        raise ConfigError(f"{path}: {shown(raw)} is not allowed; allowed: true or false")
    if hint is int:
        if isinstance(raw, int) and not isinstance(raw, bool) and abs(raw) < 2**63:
            check_number(raw, path, metadata, is_whole=True)
            return raw
        allowed = allowed_range(metadata, is_whole=True)
        raise ConfigError(f"{path}: {shown(raw)} is not allowed; allowed: {allowed}")
    if hint is float:
        if isinstance(raw, int | float) and not isinstance(raw, bool):
            value = math.inf if abs(raw) >= 1e300 else float(raw)
            check_number(value, path, metadata)
            return value
        raise ConfigError(f"{path}: {shown(raw)} is not allowed; allowed: {allowed_range(metadata)}")
    if hint is str:
        if not isinstance(raw, str):
            raise ConfigError(f"{path}: {shown(raw)} is not allowed; allowed: a word")
        if metadata.get("choices") and raw not in metadata["choices"]:
            raise ConfigError(
                f"{path}: {shown(raw)} is not allowed; allowed: {', '.join(metadata['choices'])}"
            )
        return raw
    raise TypeError(f"{path}: the loader has no rule for {hint}")
