"""
Studies: the data that define a sweep.

One YAML file, `schema: 1`, loaded as strictly as a scenario.  The built-in studies are the files of
``auv_experiment/sweeps``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from auv_core.params import load, param, shown
from auv_experiment.scenario.file import ID, ID_WORDS, find_file, is_path, read_raw

STUDIES_DIR = Path(__file__).parent
MAX_RUNS = 100_000
_KINDS = ("uniform", "log_uniform", "integers", "choice")
_MAX_SEED = 2**31 - 1


@dataclass(frozen=True, kw_only=True)
class SeedRange:
    """Consecutive seeds."""

    first: int = param("first seed", default=1, minimum=0, maximum=_MAX_SEED - MAX_RUNS)
    count: int = param("number of seeds", minimum=1, maximum=MAX_RUNS)


@dataclass(frozen=True, kw_only=True)
class Distribution:
    """Distribution of a sampled parameter; exactly one of these keys."""

    uniform: tuple[float, float] | None = param(
        "smallest and largest number, uniform between them", default=None
    )
    log_uniform: tuple[float, float] | None = param(
        "smallest and largest number, uniform in the logarithm", default=None, above=0.0
    )
    integers: tuple[int, int] | None = param("smallest and largest whole number", default=None)
    choice: tuple[Any, ...] | None = param("values, all equally likely", default=None)

    def __post_init__(self) -> None:
        """Check values against each other; messages begin with the field."""
        given = [kind for kind in _KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(
                f"{given[1] if given else _KINDS[0]}: allowed: exactly one of {', '.join(_KINDS)}"
            )
        bounds = getattr(self, given[0])
        if given[0] == "choice":
            _check_values(bounds, "choice")
        elif not bounds[0] < bounds[1]:
            raise ValueError(f"{given[0]}: {list(bounds)} is not allowed; allowed: the smaller number first")

    @property
    def is_numeric(self) -> bool:
        """Whether all possible values are numbers."""
        return self.choice is None or all(is_number(value) for value in self.choice)

    def at(self, share: float) -> Any:
        """Return the value below which `share` of the distribution lies, 0 <= share < 1."""
        if self.uniform is not None:
            low, high = self.uniform
            return low + (high - low) * share
        if self.log_uniform is not None:
            low, high = self.log_uniform
            return low * math.exp(share * math.log(high / low))
        if self.integers is not None:
            first, last = self.integers
            return first + math.floor(share * (last - first + 1))
        values = self.choice or ()
        return values[math.floor(share * len(values))]


@dataclass(frozen=True, kw_only=True)
class Sample:
    """Random points, spread evenly over every parameter (Latin hypercube)."""

    count: int = param("number of points", minimum=1, maximum=MAX_RUNS)
    seed: int = param("seed of the draw, not of the runs", default=1, minimum=0, maximum=_MAX_SEED)
    parameters: dict[str, Distribution] = param("distributions, by dotted path in the scenario")


@dataclass(frozen=True, kw_only=True)
class Label:
    """The label of a parameter or of a metric in figures and tables, and those of a parameter's values."""

    name: str | None = param("text in place of the name", default=None)
    values: tuple[str, ...] | None = param(
        "texts in place of the values, in the order of the grid", default=None
    )


@dataclass(frozen=True, kw_only=True)
class Study:
    """Everything that determines a sweep."""

    schema: int = param("version of this format", minimum=1, maximum=1)
    name: str = param("name, also of the results")
    title: str = param("description in one line")
    scenario: str = param("name of a built-in scenario, or path of a file, relative to the study's folder")
    duration_s: float | None = param("length of every run (s)", default=None, above=0.0, maximum=1e6)
    overrides: dict[str, Any] | None = param("values to set in every run, by dotted path", default=None)
    grid: dict[str, tuple[Any, ...]] | None = param(
        "values, by dotted path; all combinations are flown", default=None
    )
    sample: Sample | None = param(
        "random points; each is combined with every point of the grid", default=None
    )
    seeds: tuple[int, ...] = param(
        "seeds of every point: a list, or {first: ..., count: ...}", minimum=0, maximum=_MAX_SEED
    )
    metrics: tuple[str, ...] = param("metrics to show; if missing, a usual choice", default=())
    x: str | None = param("parameter along the axis of the figures; if missing, the first", default=None)
    by: str | None = param(
        "parameter that distinguishes the lines; if missing, all others of the grid", default=None
    )
    labels: dict[str, Label] | None = param(
        "labels of parameters and metrics of the study, by key: a text, or {name: ..., values: [...]}",
        default=None,
    )

    def __post_init__(self) -> None:
        """Check values against each other; messages begin with the field."""
        if not ID.match(self.name):
            raise ValueError(f"name: {shown(self.name)} is not allowed; allowed: {ID_WORDS}")
        if not self.title.isprintable():
            raise ValueError(f"title: {shown(self.title)} is not allowed; allowed: one line of text")
        _check_values(self.seeds, "seeds")
        _check_values(self.metrics or ("default",), "metrics")
        for path, value in self.fixed.items():
            _check_values((value,), f"overrides.{path}")
        for path, values in (self.grid or {}).items():
            _check_values(values, f"grid.{path}")
        self._check_paths()
        for field in ("x", "by"):
            self._check_axis(field)
        for key, label in (self.labels or {}).items():
            self._check_label(key, label)
        if self.n_runs > MAX_RUNS:
            raise ValueError(f"seeds: {self.n_runs} runs are not allowed; allowed: at most {MAX_RUNS}")

    @property
    def parameters(self) -> tuple[str, ...]:
        """Dotted paths of the varied parameters, without the seed: the grid's, then the sample's."""
        return (*(self.grid or {}), *(self.sample.parameters if self.sample else {}))

    @property
    def n_runs(self) -> int:
        """Number of points times number of seeds."""
        n_grid = math.prod(len(values) for values in (self.grid or {}).values())
        return n_grid * (self.sample.count if self.sample else 1) * len(self.seeds)

    @property
    def fixed(self) -> dict[str, Any]:
        """Values set in every run, by dotted path."""
        duration = {} if self.duration_s is None else {"duration_s": self.duration_s}
        return {**duration, **(self.overrides or {})}

    def _check_paths(self) -> None:
        seen = {"duration_s"} if self.duration_s is not None else set()
        sampled = self.sample.parameters if self.sample else {}
        for field, paths in (
            ("overrides", self.overrides or {}),
            ("grid", self.grid or {}),
            ("sample", sampled),
        ):
            for path in paths:
                if path == "seed":
                    raise ValueError(f"{field}.seed: not allowed; allowed: seeds under the key seeds only")
                if path in seen:
                    raise ValueError(f"{field}.{path}: is given twice; allowed: once")
                seen.add(path)

    def _check_axis(self, field: str) -> None:
        path = getattr(self, field)
        others = [p for p in self.parameters if field == "x" or p != self.x]
        if path is not None and path not in others:
            allowed = ", ".join(others) or "nothing, no parameter varies"
            raise ValueError(f"{field}: {shown(path)} is not allowed; allowed: {allowed}")

    def _check_label(self, key: str, label: Label) -> None:
        known = (*self.parameters, *self.metrics)
        if key not in known:
            allowed = ", ".join(known) or "nothing, the study names no parameter and no metric"
            raise ValueError(f"labels: {shown(key)} is not allowed; allowed: {allowed}")
        count = len((self.grid or {}).get(key, ()))
        if label.values is not None and len(label.values) != count:
            raise ValueError(
                f"labels.{key}.values: {len(label.values)} labels are not allowed; "
                f"allowed: one for each of the {count} values of the grid"
            )


def load_study(name_or_path: str) -> Study:
    """
    Return a study; if its scenario is a path, it is relative to the current folder.

    Parameters
    ----------
    name_or_path : str
        Name of a built-in study, or path of a YAML file.

    Raises
    ------
    ConfigError
        With one line for the user.

    """
    path = find_file(name_or_path, folder=STUDIES_DIR, what="study")
    study = study_from_plain(read_raw(path, "study"))
    if is_path(study.scenario):
        return replace(study, scenario=str(path.parent / study.scenario))
    return study


def study_from_plain(raw: Mapping[str, Any]) -> Study:
    """Return a study from plain data of YAML; raise ConfigError with one line for the user."""
    plain = dict(raw)
    if isinstance(plain.get("seeds"), Mapping):
        seeds = load(SeedRange, plain["seeds"], "study.seeds")
        plain["seeds"] = list(range(seeds.first, seeds.first + seeds.count))
    if isinstance(plain.get("labels"), Mapping):
        labels = plain["labels"].items()
        plain["labels"] = {key: {"name": text} if isinstance(text, str) else text for key, text in labels}
    return load(Study, plain, "study")


def list_studies() -> list[tuple[str, str]]:
    """Return name and title of every built-in study, sorted by name."""
    return sorted((p.stem, str(read_raw(p, "study").get("title", ""))) for p in STUDIES_DIR.glob("*.yaml"))


def is_number(value: object) -> bool:
    """Return whether this is a number, and not a text, mapping or truth value."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def value_text(value: object) -> str:
    """Return a parameter's value as text that YAML reads as the same value."""
    return json.dumps(value, allow_nan=False, ensure_ascii=False)


def _check_values(values: Sequence[Any], field: str) -> None:
    """Refuse an empty list, values that are no plain data, and repeated values."""
    if not values:
        raise ValueError(f"{field}: [] is not allowed; allowed: a list with at least one value")
    seen: set[str] = set()
    for value in values:
        try:
            text = value_text(value)
        except (TypeError, ValueError):
            raise ValueError(
                f"{field}: {shown(value)} is not allowed; allowed: finite numbers, words, true, false, null, "
                "and lists and mappings of these"
            ) from None
        if text in seen:
            raise ValueError(f"{field}: {shown(value)} is given twice; allowed: once")
        seen.add(text)
