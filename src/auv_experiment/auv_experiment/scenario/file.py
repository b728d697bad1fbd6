"""
Scenario files as raw data: finding and reading them, `--set` overrides, and presets.

Everything here works on plain mappings, before `auv_experiment.scenario.schema` loads them into its
dataclasses; errors are one line.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import auv_control.controllers
import auv_core.models
import auv_sim.acoustics
from auv_core.params import ConfigError, shown
from auv_core.plugins import plugin_places
from auv_experiment.scenario.raw_agents import completed, merged, with_flock
from auv_experiment.scenario.strict_yaml import parse_yaml, read_text

MOST_VEHICLES = 254
SCENARIOS_DIR = Path(__file__).parent
ID = re.compile(r"[a-z][a-z0-9_]{0,30}\Z")
ID_WORDS = "a lower-case letter, then at most 30 lower-case letters, digits or underscores"


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
    Return the raw scenario with fleets expanded, the presets of models, controllers and acoustics filled in,
    and the agents of vehicles completed from the common one.
    """
    filled = _with_fleet(raw)
    acoustics = raw.get("acoustics")
    if isinstance(acoustics, Mapping) and acoustics.get("preset") not in (None, ""):
        preset = _preset(auv_sim.acoustics, acoustics["preset"], "scenario.acoustics.preset")
        sections = {key: merged(preset.get(key), value) for key, value in acoustics.items()}
        filled["acoustics"] = {**preset, **sections}
    acoustics = filled.get("acoustics")
    modem = acoustics.get("modem") if isinstance(acoustics, Mapping) else None
    common = _with_controller(raw.get("agent"), "scenario.agent")
    vehicles = filled.get("vehicles")
    if isinstance(vehicles, list):
        filled["vehicles"] = [
            _filled_vehicle(vehicle, f"scenario.vehicles[{i}]", common, modem)
            for i, vehicle in enumerate(vehicles)
        ]
    if isinstance(common, Mapping):
        filled["agent"] = with_flock(common, modem)
    return filled


def _filled_vehicle(vehicle: Any, path: str, common: Any, modem: Any) -> Any:
    """Return a vehicle with the preset of its model and, if it has an agent of its own, all of that."""
    filled = _with_preset(vehicle, "model", auv_core.models, f"{path}.model")
    own = filled.get("agent") if isinstance(filled, Mapping) else None
    if not isinstance(own, Mapping):
        return filled
    controller = own.get("controller")
    if isinstance(controller, Mapping) and "preset" in controller and isinstance(common, Mapping):
        common = {key: value for key, value in common.items() if key != "controller"}
    own = _with_controller(own, f"{path}.agent")
    return {**filled, "agent": with_flock(completed(own, common), modem)}


def _with_controller(agent: Any, path: str) -> Any:
    return _with_preset(agent, "controller", auv_control.controllers, f"{path}.controller")


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


def _with_preset(owner: Any, key: str, package: ModuleType, path: str) -> Any:
    """Return the mapping `owner` with the preset of its plugin section `key` filled in."""
    section = owner.get(key) if isinstance(owner, Mapping) else None
    if not isinstance(section, Mapping) or "preset" not in section:
        return owner
    preset = _preset(package, section["preset"], f"{path}.preset")
    explicit = {name: value for name, value in section.items() if name != "preset"}
    return {**owner, key: merged(preset, explicit)}


def _preset(package: ModuleType, name: object, path: str) -> dict[str, Any]:
    places = reversed(plugin_places(package.__name__))
    files = {file.stem: file for place in places for file in place.glob("presets/*.yaml")}
    if not isinstance(name, str) or name not in files:
        raise ConfigError(f"{path}: {shown(name)} is not allowed; allowed: {', '.join(sorted(files))}")
    return read_raw(files[name])
