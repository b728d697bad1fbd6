"""A scenario as data: read, change, check."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from functools import reduce
from pathlib import Path
from typing import Any

from auv_core.machine.whole_files import write_text
from auv_core.params import ConfigError, dump
from auv_experiment.scenario import loading, schema
from auv_experiment.scenario.file import find_file, put, read_raw
from auv_experiment.scenario.strict_yaml import to_yaml
from shoal.plain import plain


def scenarios() -> dict[str, str]:
    """
    Return the title of every built-in scenario, by name.

    Examples
    --------
    >>> import shoal
    >>> "flock_acoustic" in shoal.scenarios()
    True

    """
    return dict(loading.list_scenarios())


def load(name_or_path: str | Path) -> Scenario:
    """
    Return a scenario by its name, or from a YAML file.

    Parameters
    ----------
    name_or_path : str or Path
        A name of `scenarios`, or a path (a Path, or text with a slash or the ending .yaml or .yml).

    Raises
    ------
    ConfigError
        With one line that has the key, its value and what is allowed.

    Examples
    --------
    >>> import shoal
    >>> shoal.load("flock_acoustic")["leaders"]
    ['auv_1']

    """
    path = name_or_path if isinstance(name_or_path, Path) else find_file(name_or_path)
    scenario = Scenario(read_raw(path))
    scenario.check()
    return scenario


class Scenario(MutableMapping[str, Any]):
    """
    A scenario as data under dotted keys. Changes are checked by `check`, and when the scenario is flown.

    A key that the scenario leaves out has its default value. Items of lists have numbers as keys:
    ``vehicles.0.heading_rad``. The keys are those of a scenario's file.

    Parameters
    ----------
    raw : mapping
        Content of a scenario's file.

    Examples
    --------
    >>> import shoal
    >>> scenario = shoal.load("flock_acoustic")
    >>> scenario["acoustics.outage.params.loss_prob"] = 0.5
    >>> scenario["dt_s"]
    0.02
    >>> scenario["duration_s"] = -1.0
    >>> scenario.check()
    Traceback (most recent call last):
        ...
    auv_core.params.ConfigError: scenario.duration_s: -1.0 is not allowed; allowed: a finite number ...

    """

    def __init__(self, raw: Mapping[str, Any]) -> None:
        self._raw: dict[str, Any] = plain(raw)

    def __getitem__(self, key: str) -> Any:
        keys = key.split(".")
        try:
            return reduce(_inner, keys, self._raw)
        except LookupError:
            return reduce(_inner, keys, dump(self.resolved()))

    def __setitem__(self, key: str, value: Any) -> None:
        put(self._raw, key, lambda: plain(value))

    def __delitem__(self, key: str) -> None:
        *outer, last = key.split(".")
        owner = reduce(_inner, outer, self._raw)
        del owner[int(last) if isinstance(owner, list) else last]

    def __iter__(self) -> Iterator[str]:
        return iter(self._raw)

    def __len__(self) -> int:
        return len(self._raw)

    def __repr__(self) -> str:
        return f"<shoal.Scenario {self._raw.get('name')}: {self._raw.get('title')}>"

    def copy(self) -> Scenario:
        """Return a copy; changing it does not change this one."""
        return Scenario(self._raw)

    def check(self) -> None:
        """Raise ConfigError with one line if the scenario cannot be flown."""
        self.resolved()

    def resolved(self, *, seed: int | None = None, duration_s: float | None = None) -> schema.Scenario:
        """
        Return the checked scenario, with presets filled in and random starts drawn.

        Parameters
        ----------
        seed : int, optional
            Replaces the key `seed`.
        duration_s : float, optional
            Replaces the key `duration_s` (s).

        Raises
        ------
        ConfigError
            With one line.

        """
        changes = {"seed": seed, "duration_s": duration_s}
        given = {key: value for key, value in changes.items() if value is not None}
        return loading.scenario_from_raw(plain({**self._raw, **given}))

    def to_yaml(self) -> str:
        """Return the text of a file from which `load` makes an equal scenario."""
        return to_yaml(self._raw)

    def save(self, path: str | Path) -> Path:
        """Write the scenario as a YAML file, completely or not at all, and return its path."""
        write_text(Path(path), self.to_yaml())
        return Path(path)


def resolve(
    scenario: Scenario | schema.Scenario | str | Path,
    *,
    seed: int | None = None,
    duration_s: float | None = None,
) -> schema.Scenario:
    """Return the resolved scenario (`Scenario.resolved`) for a scenario, a name or a path."""
    if isinstance(scenario, schema.Scenario):
        if seed is not None or duration_s is not None:
            raise ConfigError("seed, duration_s: not allowed with a resolved scenario; allowed: shoal.load")
        return scenario
    found = scenario if isinstance(scenario, Scenario) else load(scenario)
    return found.resolved(seed=seed, duration_s=duration_s)


def _inner(owner: Any, key: str) -> Any:
    if isinstance(owner, Mapping):
        return owner[key]
    if isinstance(owner, list | tuple) and key.isdecimal():
        return owner[int(key)]
    raise KeyError(key)
