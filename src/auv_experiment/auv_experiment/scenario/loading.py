"""
Scenarios as text: read from YAML with overrides, seed and presets; written as YAML and as JSON.

`auv_experiment.scenario.schema` defines their content.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from auv_core.params import dump, load
from auv_experiment.scenario.file import SCENARIOS_DIR, find_file, override, read_raw, with_presets
from auv_experiment.scenario.random_starts import with_starts
from auv_experiment.scenario.schema import Scenario
from auv_experiment.scenario.strict_yaml import to_yaml


def load_scenario(
    name_or_path: str,
    *,
    overrides: Sequence[str] = (),
    seed: int | None = None,
    duration_s: float | None = None,
) -> Scenario:
    """
    Return a resolved scenario: presets filled in and random starts drawn.

    Parameters
    ----------
    name_or_path : str
        Name of a built-in scenario, or path of a YAML file (anything with a slash or ending in .yaml or
        .yml).
    overrides : sequence of str
        ``path.to.key=value`` with the value in YAML; a number selects an item of a list.
    seed, duration_s : int, float
        Override the keys of the same name.

    Raises
    ------
    ConfigError
        With one line for the user.

    """
    return with_starts(_undrawn(name_or_path, overrides, seed=seed, duration_s=duration_s))


def load_for_seeds(
    name_or_path: str, *, overrides: Sequence[str] = (), seeds: Iterable[int]
) -> Iterator[Scenario]:
    """
    Yield the scenario of `load_scenario` for each seed; the file is read once.

    Raises
    ------
    ConfigError
        With one line for the user; the seeds are not checked.

    """
    undrawn = _undrawn(name_or_path, overrides)
    for seed in seeds:
        yield with_starts(replace(undrawn, seed=seed))


def scenario_from_raw(raw: Mapping[str, Any]) -> Scenario:
    """
    Return the scenario that `load_scenario` makes from a file with this content; raise ConfigError with one
    line.
    """
    return with_starts(load(Scenario, with_presets(dict(raw)), "scenario"))


def list_scenarios() -> list[tuple[str, str]]:
    """Return name and title of every built-in scenario, sorted by name."""
    return sorted((path.stem, str(read_raw(path).get("title", ""))) for path in SCENARIOS_DIR.glob("*.yaml"))


def scenario_to_json(scenario: Scenario) -> str:
    """Return the scenario as JSON on one line, from which `scenario_from_json` makes an equal one."""
    return json.dumps(dump(scenario), allow_nan=False)


def scenario_from_json(text: str) -> Scenario:
    """
    Return the scenario that `scenario_to_json` wrote; raise ConfigError if one of its plugins does not exist.
    """
    return load(Scenario, json.loads(text), "scenario")


def scenario_to_yaml(scenario: Scenario) -> str:
    """Return the scenario as YAML from which `load_scenario` makes an equal one."""
    return to_yaml(dump(scenario))


def _undrawn(
    name_or_path: str, overrides: Sequence[str], *, seed: int | None = None, duration_s: float | None = None
) -> Scenario:
    """Return the scenario before its random starts are drawn."""
    raw = read_raw(find_file(name_or_path))
    for text in overrides:
        override(raw, text)
    if seed is not None:
        raw["seed"] = seed
    if duration_s is not None:
        raw["duration_s"] = duration_s
    return load(Scenario, with_presets(raw), "scenario")
