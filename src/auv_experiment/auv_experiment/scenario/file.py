"""
Scenario files as raw data: finding and reading them, `--set` overrides, and presets.

Everything here works on plain mappings, before `auv_experiment.scenario.schema` loads them into its
dataclasses; errors are one line.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import auv_control.controllers
import auv_core.models
import auv_sim.acoustics
from auv_core.params import ConfigError, shown
from auv_core.plugins import PluginError, plugin_places
from auv_experiment.scenario.strict_yaml import parse_yaml, read_text

MOST_VEHICLES = 254
SCENARIOS_DIR = Path(__file__).parent
ID = re.compile(r"[a-z][a-z0-9_]{0,30}\Z")
ID_WORDS = "a lower-case letter, then at most 30 lower-case letters, digits or underscores"

_FLOCK_WITHOUT_MODEM: dict[str, Any] = {
    "flocking": {"kind": "potential"},
    "separation": {"kind": "mathematical"},
    "consensus": {"kind": "thesis"},
}
_FLOCK_ON_A_MODEM: dict[str, Any] = {
    "flocking": {"kind": "communication_aware"},
    "separation": {"kind": "mathematical"},
    "consensus": {"kind": "neighbour_mean"},
    "neighbours": {
        "timeout_s": 900.0,
        "acceleration_memory_s": 60.0,
        "velocity_memory_s": 15.0,
    },
    "hold_s": 60.0,
}


def is_path(name_or_path: str) -> bool:
    """
    Return whether this is a path (it has a slash or ends in .yaml or .yml), not the name of a built-in file.
    """
    return "/" in name_or_path or name_or_path.endswith((".yaml", ".yml"))


def find_file(name_or_path: str, *, folder: Path = SCENARIOS_DIR, what: str = "scenario") -> Path:
    """
    Return the file of a scenario or a study, given a path or the name of a built-in one in `folder`.

    Raises
    ------
    ConfigError
        If the name is not built in.

    """
    if is_path(name_or_path):
        return Path(name_or_path)
    path = folder / f"{name_or_path}.yaml"
    if not ID.match(name_or_path) or not path.is_file():
        names = ", ".join(sorted(p.stem for p in folder.glob("*.yaml")))
        raise ConfigError(
            f"{what}: {name_or_path!r} is not allowed; allowed: {names}, or the path of a .yaml file"
        )
    return path


def read_raw(path: Path, what: str = "scenario") -> dict[str, Any]:
    """
    Return the mapping in a YAML file.

    Raises
    ------
    ConfigError
        If the file cannot be read, is not YAML that `strict_yaml` accepts, or does not hold a mapping.

    """
    raw = parse_yaml(read_text(path, what), what)
    if not isinstance(raw, dict):
        raise ConfigError(f"{what}: {shown(raw)} is not allowed; allowed: a mapping of {what} keys")
    return raw


def override(raw: dict[str, Any], override: str) -> None:
    """
    Apply the override ``path.to.key=value`` to the raw scenario.

    Raises
    ------
    ConfigError
        If the text is no override, the path does not exist, or the value is not YAML.

    """
    path, equals, text = override.partition("=")
    if not equals or not all(path.split(".")) or not path.isprintable():
        raise ConfigError(f"--set {shown(override)} is not allowed; allowed: path.to.key=value")
    put(raw, path, lambda: parse_yaml(text, f"--set {path}"))


def put(raw: dict[str, Any], path: str, value: Callable[[], Any]) -> None:
    """
    Store the result of `value` under a dotted path; `value` is called once the place is found.

    Raises
    ------
    ConfigError
        If the path does not exist.

    """
    keys = path.split(".")
    target: Any = raw
    for depth in range(1, len(keys)):
        where = _place(target, keys[:depth])
        inner = target.get(where) if isinstance(target, dict) else target[where]
        # A copy, so that data which an alias (*name) puts in several places changes only here.
        target[where] = {} if inner is None else inner.copy() if isinstance(inner, dict | list) else inner
        target = target[where]
    place = _place(target, keys)
    target[place] = value()


def _place(target: Any, keys: list[str]) -> str | int:
    """Return the key or index of the last of `keys` in `target`, which the other keys lead to."""
    if isinstance(target, dict):
        return keys[-1]
    if not isinstance(target, list):
        raise ConfigError(f"--set {'.'.join(keys)}: {'.'.join(keys[:-1])} has no keys; it is {shown(target)}")
    names = [str(index) for index in range(len(target))]
    if keys[-1] not in names:
        allowed = f"a number from 0 to {names[-1]}" if names else "nothing, the list is empty"
        raise ConfigError(f"--set {'.'.join(keys)}: {keys[-1]!r} is not allowed; allowed: {allowed}")
    return int(keys[-1])


def with_presets(raw: dict[str, Any]) -> dict[str, Any]:
    """
    Return the raw scenario with fleets expanded and the presets of models, controllers and acoustics filled
    in.
    """
    filled = _with_fleet(raw)
    vehicles = filled.get("vehicles")
    if isinstance(vehicles, list):
        filled["vehicles"] = [
            _with_preset(v, "model", auv_core.models, f"scenario.vehicles[{i}].model")
            for i, v in enumerate(vehicles)
        ]
    agent = raw.get("agent")
    if isinstance(agent, Mapping):
        path = "scenario.agent.controller"
        filled["agent"] = _with_preset(agent, "controller", auv_control.controllers, path)
    acoustics = raw.get("acoustics")
    if isinstance(acoustics, Mapping) and acoustics.get("preset") not in (None, ""):
        preset = _preset(auv_sim.acoustics, acoustics["preset"], "scenario.acoustics.preset")
        sections = {key: _merged(preset.get(key), value) for key, value in acoustics.items()}
        filled["acoustics"] = {**preset, **sections}
    return _with_flock(filled)


def _with_fleet(raw: dict[str, Any]) -> dict[str, Any]:
    """
    Return the raw scenario with a fleet, ``vehicles: {count: N, model: ...}``, expanded to a list of
    vehicles.

    Their ids are auv_1 to auv_N; ``leaders: all`` names all vehicles.
    """
    filled = dict(raw)
    fleet = raw.get("vehicles")
    if isinstance(fleet, Mapping):
        count = fleet.get("count")
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= MOST_VEHICLES:
            raise ConfigError(
                f"scenario.vehicles.count: {shown(count)} is not allowed; "
                f"allowed: a whole number from 1 to {MOST_VEHICLES}"
            )
        same = {key: value for key, value in fleet.items() if key != "count"}
        filled["vehicles"] = [{"id": f"auv_{i + 1}", **same} for i in range(count)]
    vehicles = filled.get("vehicles")
    if raw.get("leaders") == "all" and isinstance(vehicles, list):
        filled["leaders"] = [v["id"] for v in vehicles if isinstance(v, Mapping) and "id" in v]
    return filled


def _with_flock(filled: dict[str, Any]) -> dict[str, Any]:
    """
    Return the raw scenario with the missing parts of a flock filled in.

    On the ideal modem these are the thesis's parts. On every other modem they are `communication_aware` and
    the parts that suit it.
    """
    agent, acoustics = filled.get("agent"), filled.get("acoustics")
    if not isinstance(agent, Mapping) or not isinstance(acoustics, Mapping) or "flocking" in agent:
        return filled
    try:
        controller = auv_control.controllers.controller_class(agent["controller"]["kind"])
    except (KeyError, TypeError, PluginError):
        return filled
    modem = acoustics.get("modem")
    if controller.follows != "velocity" or not isinstance(modem, Mapping):
        return filled
    parts = _FLOCK_WITHOUT_MODEM if modem.get("kind") == "ideal" else _FLOCK_ON_A_MODEM
    merged = {**copy.deepcopy(parts), **agent}
    if isinstance(agent.get("neighbours"), Mapping):
        merged["neighbours"] = {**parts.get("neighbours", {}), **agent["neighbours"]}
    return {**filled, "agent": merged}


def _with_preset(owner: Any, key: str, package: ModuleType, path: str) -> Any:
    """Return the mapping `owner` with the preset of its plugin section `key` filled in."""
    section = owner.get(key) if isinstance(owner, Mapping) else None
    if not isinstance(section, Mapping) or "preset" not in section:
        return owner
    preset = _preset(package, section["preset"], f"{path}.preset")
    explicit = {name: value for name, value in section.items() if name != "preset"}
    return {**owner, key: _merged(preset, explicit)}


def _preset(package: ModuleType, name: object, path: str) -> dict[str, Any]:
    places = reversed(plugin_places(package.__name__))
    files = {file.stem: file for place in places for file in place.glob("presets/*.yaml")}
    if not isinstance(name, str) or name not in files:
        raise ConfigError(f"{path}: {shown(name)} is not allowed; allowed: {', '.join(sorted(files))}")
    return read_raw(files[name])


def _merged(preset: Any, explicit: Any) -> Any:
    """
    Return a plugin section: explicit keys override those of the preset, also within its mappings, unless they
    name another kind.
    """
    if not isinstance(preset, Mapping) or not isinstance(explicit, Mapping):
        return explicit
    if "kind" in explicit and explicit["kind"] != preset.get("kind"):
        return explicit
    return {**preset, **{key: _merged(preset.get(key), value) for key, value in explicit.items()}}
