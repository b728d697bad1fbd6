"""Every key of a scenario and of a study: type, unit, range, default, meaning."""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Iterator
from typing import Any, NamedTuple

from auv_core.params import Section, dump
from auv_core.plugins import find_plugin, list_plugins, plugin_places
from auv_experiment.scenario.schema import Scenario
from auv_experiment.scenario.strict_yaml import to_yaml
from auv_experiment.sweeps.study import Study
from from_code.markdown import code, table

UNITS = {
    "_kgpm3": "kg/m³",
    "_kgm2": "kg m²",
    "_radps": "rad/s",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_bps": "bit/s",
    "_rad": "rad",
    "_bytes": "bytes",
    "_nm": "N m",
    "_hz": "Hz",
    "_khz": "kHz",
    "_db": "dB",
    "_kg": "kg",
    "_ps": "1/s",
    "_m": "m",
    "_s": "s",
    "_n": "N",
    "_w": "W",
}
"""Units by the ending of a name (docs/reference/conventions.md)."""

HEAD = ("key", "type", "unit", "allowed", "default", "meaning")
_WORDS = {float: "number", int: "whole number", bool: "true or false", str: "word", Any: "any value"}
_PLURALS = {float: "numbers", int: "whole numbers", bool: "truth values", str: "words", Any: "values"}


class Key(NamedTuple):
    """One key: its dotted path and its field."""

    path: str
    hint: Any
    field: dataclasses.Field[Any]


def keys_of(cls: Any, prefix: str = "") -> Iterator[Key]:
    """Yield the keys of a configuration, those of the objects in it under dotted paths."""
    hints = typing.get_type_hints(cls)
    for field in dataclasses.fields(cls):
        path, hint = prefix + field.name, _without_none(hints[field.name])
        inner, ending = _inner(hint)
        yield Key(path + ending, hint, field)
        if dataclasses.is_dataclass(inner) and inner is not Section:
            yield from keys_of(inner, f"{path}{ending}.")


def scenario_keys() -> str:
    """Return all keys of a scenario, then those of the plugins by folder."""
    presets = ", ".join(map(code, _presets("auv_sim.acoustics")))
    parts = [
        table(HEAD, map(_row, keys_of(Scenario))),
        f"Presets of `acoustics` (`preset: NAME`, and what differs): {presets}.\n",
    ]
    for folder in plugin_folders():
        parts += _plugins(folder)
    return "\n".join(parts)


def study_keys() -> str:
    """Return all keys of a study."""
    return table(HEAD, map(_row, keys_of(Study)))


def plugin_folders() -> list[str]:
    """Return the plugin folders that the keys of a scenario choose from, in their order."""
    named = [key.field.metadata.get("plugins") for key in keys_of(Scenario)]
    return list(dict.fromkeys(each for each in named if each))


def _plugins(folder: str) -> Iterator[str]:
    """Yield the part of a page that lists the kinds of a plugin folder."""
    keys = [key.path for key in keys_of(Scenario) if key.field.metadata.get("plugins") == folder]
    yield f"## {_title(folder)} {{ #{_anchor(folder)} }}\n"
    yield f"Chosen by {' and '.join(map(code, keys))}; files of `{folder.replace('.', '/')}`.\n"
    if presets := _presets(folder):
        yield f"Presets (`preset: NAME` in place of `kind` and `params`): {', '.join(map(code, presets))}.\n"
    for kind in list_plugins(folder):
        module = find_plugin(folder, kind)
        yield f"### {code(kind)} {{ #{_anchor(folder)}-{kind} }}\n"
        yield _first_sentence(module.__doc__ or "") + "\n"
        rows = [_row(key) for key in keys_of(module.Params)]
        yield table(HEAD, rows) if rows else "No parameters.\n"


def _row(key: Key) -> tuple[str, ...]:
    metadata = key.field.metadata
    return (
        _broken_at_dots(key.path),
        _type_words(key),
        unit_of(key),
        _allowed_words(key),
        _default_words(key.field),
        str(metadata["doc"]),
    )


def _broken_at_dots(path: str) -> str:
    """Return a dotted path as code that may be broken after its dots, where a column is narrow."""
    return "".join(f"<code>{name}</code><wbr>" for name in re.findall(r"[^.]+\.?", path))


def unit_of(key: Key) -> str:
    """Return the unit that the meaning of a key states, else that of its ending; a dash for none."""
    groups = _PARENTHESES.findall(str(key.field.metadata["doc"]))
    stated = [group.split(";")[0] for group in groups if _UNIT.fullmatch(group.split(";")[0])]
    ending = next((unit for each, unit in UNITS.items() if key.field.name.endswith(each)), "–")
    return ", ".join(dict.fromkeys(stated)) or ending


_PARENTHESES = re.compile(r"\(((?:[^()]|\([^()]*\))*)\)")
_UNIT = re.compile(
    r"(?:(?:1|N|m|s|kg|rad|dB|k?Hz|W|bits?|bytes|per|degrees|Celsius|parts|thousand)(?:\^\d)?"
    r"(?:, | |/)?|[()])+"
)


def _type_words(key: Key) -> str:
    folder = key.field.metadata.get("plugins")
    if folder:
        return f"[{{kind, params}}](#{_anchor(folder)})"
    words = _hint_words(key.hint)
    choices = key.field.metadata.get("choices")
    return "one of " + ", ".join(map(code, choices)) if choices else words


def _hint_words(hint: Any) -> str:
    hint = _without_none(hint)
    inner, ending = _inner(hint)
    if dataclasses.is_dataclass(inner):
        return {"": "section", "[]": "list of sections", ".NAME": "section with free names"}[ending]
    if typing.get_origin(hint) is tuple:
        items = typing.get_args(hint)
        if items[1:] == (Ellipsis,):
            return f"list of {_plural(items[0])}"
        return f"list of {len(items)} {_plural(items[0])}"
    if typing.get_origin(hint) is dict:
        return f"section of {_plural(typing.get_args(hint)[1])} with free names"
    return _WORDS[hint]


def _plural(hint: Any) -> str:
    return _PLURALS.get(hint, "lists")


def _allowed_words(key: Key) -> str:
    bounds = key.field.metadata
    signs = {"above": "> ", "minimum": "≥ ", "maximum": "≤ "}
    is_whole = int in (key.hint, *typing.get_args(key.hint))
    parts = [
        f"{sign}{bounds[name] if is_whole else format(bounds[name], 'g')}"
        for name, sign in signs.items()
        if bounds.get(name) is not None
    ]
    return ", ".join(parts) or "–"


def _default_words(field: dataclasses.Field[Any]) -> str:
    if field.default is dataclasses.MISSING:
        return "required"
    if isinstance(field.default, Section):
        return code(field.default.kind)
    if dataclasses.is_dataclass(field.default):
        return "–"
    plain = dump(field.default)
    return "none" if plain in (None, [], "") else code(to_yaml(plain).removesuffix("...\n").strip())


def _without_none(hint: Any) -> Any:
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return next(option for option in typing.get_args(hint) if option is not type(None))
    return hint


def _inner(hint: Any) -> tuple[Any, str]:
    """Return the type of the items of a list or mapping, or the type itself, and what a path gets for it."""
    items = typing.get_args(hint)
    if typing.get_origin(hint) is tuple and dataclasses.is_dataclass(items[0]):
        return items[0], "[]"
    if typing.get_origin(hint) is dict and dataclasses.is_dataclass(items[1]):
        return items[1], ".NAME"
    return hint, ""


def _title(folder: str) -> str:
    return folder.rpartition(".")[2].replace("_", " ").capitalize()


def _anchor(folder: str) -> str:
    return folder.rpartition(".")[2]


def _presets(folder: str) -> list[str]:
    return sorted(path.stem for place in plugin_places(folder) for path in place.glob("presets/*.yaml"))


def _first_sentence(text: str) -> str:
    return " ".join(text.strip().split("\n\n")[0].split())
