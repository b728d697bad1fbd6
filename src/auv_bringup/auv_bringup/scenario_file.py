"""
Scenario files as raw data: reading YAML strictly, `--set` overrides, and presets.

Everything here works on plain mappings, before `auv_bringup.scenario` loads them into its dataclasses; errors
are one line.
"""

from __future__ import annotations

import re
import reprlib
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import yaml

import auv_core.models
import auv_sim.acoustics
from auv_core.params import ConfigError

SCENARIOS_DIR = Path(__file__).parent / "scenarios"
ID = re.compile(r"[a-z][a-z0-9_]{0,30}\Z")


class _StrictYaml(yaml.SafeLoader):
    """YAML without duplicate keys, and with numbers such as 1e-3 read as numbers."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key!r} stands twice", node.start_mark
                )
        return super().construct_mapping(node, deep)


_StrictYaml.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?[0-9][0-9_]*(\.[0-9_]*)?[eE][-+]?[0-9]+\Z"),
    list("-+0123456789"),
)


def _parse_yaml(text: str, where: str) -> Any:
    try:
        return yaml.load(text, Loader=_StrictYaml)  # noqa: S506 (a SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        raise ConfigError(f"{where}: not YAML: {error.problem} (line {line})") from None
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        reason = " ".join(str(error).split()) or "nested too deeply"
        raise ConfigError(f"{where}: not YAML: {reason}") from None


def find_file(name_or_path: str) -> Path:
    """
    Return the file of a scenario: a path, or the name of a built-in one.

    Raises
    ------
    ConfigError
        For a name that is not built in.

    """
    if "/" in name_or_path or name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    path = SCENARIOS_DIR / f"{name_or_path}.yaml"
    if not ID.match(name_or_path) or not path.is_file():
        names = ", ".join(sorted(p.stem for p in SCENARIOS_DIR.glob("*.yaml")))
        raise ConfigError(
            f"scenario: {name_or_path!r} is not allowed; allowed: {names}, or the path of a .yaml file"
        )
    return path


def read_raw(path: Path) -> dict[str, Any]:
    """
    Return the mapping in a YAML file.

    Raises
    ------
    ConfigError
        For a file that cannot be read, is not YAML, has a key twice, or does not hold a mapping.

    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise ConfigError(
            f"scenario: {str(path)!r} cannot be read ({reason}); allowed: a readable YAML file"
        ) from None
    raw = _parse_yaml(text, "scenario")
    if not isinstance(raw, dict):
        raise ConfigError(
            f"scenario: {reprlib.repr(raw)} is not allowed; allowed: a mapping of scenario keys"
        )
    return raw


def override(raw: dict[str, Any], override: str) -> None:
    """Put ``path.to.key=value`` into the raw scenario."""
    path, equals, text = override.partition("=")
    keys = path.split(".")
    if not equals or not all(keys):
        raise ConfigError(f"--set {override!r} is not allowed; allowed: path.to.key=value")
    target: Any = raw
    for index, key in enumerate(keys):
        last = index == len(keys) - 1
        where: Any = key
        if isinstance(target, list):
            if not key.isdecimal() or int(key) >= len(target):
                raise ConfigError(
                    f"--set {path}: {key!r} is not allowed; allowed: a number from 0 to {len(target) - 1}"
                )
            where = int(key)
        elif not isinstance(target, dict):
            raise ConfigError(
                f"--set {path}: {'.'.join(keys[:index])} has no keys; it is {reprlib.repr(target)}"
            )
        elif not last and target.get(key) is None:
            target[key] = {}
        if last:
            target[where] = _parse_yaml(text, f"--set {path}")
        else:
            target = target[where]


def with_presets(raw: dict[str, Any]) -> dict[str, Any]:
    """Return the raw scenario with the presets of models and acoustics filled in."""
    filled = dict(raw)
    vehicles = raw.get("vehicles")
    if isinstance(vehicles, list):
        filled["vehicles"] = [
            _vehicle_with_preset(v, f"scenario.vehicles[{i}].model") for i, v in enumerate(vehicles)
        ]
    acoustics = raw.get("acoustics")
    if isinstance(acoustics, Mapping) and acoustics.get("preset") not in (None, ""):
        preset = _preset(auv_sim.acoustics, acoustics["preset"], "scenario.acoustics.preset")
        sections = {key: _merged(preset.get(key), value) for key, value in acoustics.items()}
        filled["acoustics"] = {**preset, **sections}
    return filled


def _vehicle_with_preset(vehicle: Any, path: str) -> Any:
    model = vehicle.get("model") if isinstance(vehicle, Mapping) else None
    if not isinstance(model, Mapping) or "preset" not in model:
        return vehicle
    preset = _preset(auv_core.models, model["preset"], f"{path}.preset")
    explicit = {key: value for key, value in model.items() if key != "preset"}
    return {**vehicle, "model": _merged(preset, explicit)}


def _preset(package: ModuleType, name: object, path: str) -> dict[str, Any]:
    folder = Path(str(package.__file__)).parent / "presets"
    names = sorted(file.stem for file in folder.glob("*.yaml"))
    if not isinstance(name, str) or name not in names:
        raise ConfigError(f"{path}: {reprlib.repr(name)} is not allowed; allowed: {', '.join(names)}")
    return read_raw(folder / f"{name}.yaml")


def _merged(preset: Any, explicit: Any) -> Any:
    """Return a plugin section: the explicit keys over the preset's, unless they name another kind."""
    if not isinstance(preset, Mapping) or not isinstance(explicit, Mapping):
        return explicit
    if "kind" in explicit and explicit["kind"] != preset.get("kind"):
        return explicit
    merged = {**preset, **explicit}
    if isinstance(preset.get("params"), Mapping) and isinstance(explicit.get("params"), Mapping):
        merged["params"] = {**preset["params"], **explicit["params"]}
    return merged
