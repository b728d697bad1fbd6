"""Metrics that users add: files of `auv_experiment.metrics.OwnMetrics`."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

from auv_core.params import ConfigError, shown
from auv_experiment.metrics import Meaning
from auv_experiment.metrics.descriptions import MEANINGS, family_meaning
from auv_experiment.metrics.finite import plain
from auv_experiment.own_files import WORD, WORDS, failure_line, load_own_files, read_only

if TYPE_CHECKING:
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario

FAILED = "own_metrics_failed"
_OF_SWEEPS = {"run", "key", "status", "error", "wall_s", "cpu_s"}
"""Other columns of a sweep's table."""


def own_files_of_metrics() -> dict[str, ModuleType]:
    """
    Return the files of own metrics, by name.

    Raises
    ------
    ConfigError
        If a file is not an `OwnMetrics`, or describes an existing metric; one line.

    """
    files = load_own_files(__package__)
    taken: dict[str, str] = {}
    for name, module in files.items():
        place = f"metrics/{name}.py"
        if not callable(getattr(module, "compute", None)):
            raise ConfigError(f"{place}: compute is missing; allowed: a function of recording and scenario")
        meanings = getattr(module, "MEANINGS", None)
        if not isinstance(meanings, Mapping) or not meanings:
            raise ConfigError(f"{place}: MEANINGS is missing; allowed: a Meaning for each metric, by key")
        for key, meaning in meanings.items():
            _check(place, key, meaning, taken)
            taken[key] = place
    return files


def own_meaning(key: str) -> Meaning | None:
    """Return the meaning of an own metric, None for another key."""
    for module in own_files_of_metrics().values():
        if key in module.MEANINGS:
            meaning: Meaning = module.MEANINGS[key]
            return meaning
    return None


def own_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the own metrics of a run, and failures under ``own_metrics_failed``.

    If a file raises, or returns values that metrics.json cannot store, its metrics are None.
    """
    metrics: dict[str, Any] = {}
    failures = []
    for module in own_files_of_metrics().values():
        metrics |= dict.fromkeys(module.MEANINGS)
        try:
            metrics |= _computed(module, recording, scenario)
        except Exception as error:
            failures.append(failure_line(module, error))
    if metrics:
        metrics[FAILED] = "; ".join(failures) or None
    return metrics


def failure_warning(metrics: Mapping[str, Any]) -> str:
    """Return one line for the user if own metrics failed, otherwise an empty text."""
    failed = metrics.get(FAILED)
    return f"{failed}; the own metrics of that file have no value" if failed else ""


def _check(place: str, key: object, meaning: object, taken: Mapping[str, str]) -> None:
    if not isinstance(key, str) or not WORD.match(key):
        raise ConfigError(f"{place}: MEANINGS: {shown(key)} is not allowed; allowed: {WORDS}")
    if key in MEANINGS or family_meaning(key) or key in _OF_SWEEPS or key in taken:
        raise ConfigError(
            f"{place}: MEANINGS: {key!r} is taken by {taken.get(key, 'Shoal')}; allowed: another key"
        )
    if not isinstance(meaning, Meaning):
        raise ConfigError(f"{place}: MEANINGS: {key}: {shown(meaning)} is not allowed; allowed: a Meaning")


def _computed(module: ModuleType, recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """Return the values that a file computes; raise TypeError if they do not match the contract."""
    computed = module.compute(read_only(recording), scenario)
    if not isinstance(computed, Mapping):
        raise TypeError(f"compute returned {shown(computed)}; allowed: values by key")
    for key in computed:
        if key not in module.MEANINGS:
            raise TypeError(f"compute returned the key {shown(key)}; allowed: {', '.join(module.MEANINGS)}")
    values = {key: plain(value) for key, value in computed.items()}
    for key, value in values.items():
        if not _is_value(value):
            raise TypeError(f"{key}: {shown(value)} is not allowed; allowed: a value or a list")
    return values


def _is_value(value: object) -> bool:
    if isinstance(value, list):
        return all(map(_is_value, value))
    return value is None or isinstance(value, bool | int | float | str)
