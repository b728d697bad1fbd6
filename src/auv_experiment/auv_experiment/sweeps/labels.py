"""
Short labels of a sweep's parameters, values and metrics: those of the study, or else derived from the names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from auv_experiment.metrics.wording import meaning_of
from auv_experiment.sweeps.study import is_number, value_text
from auv_experiment.sweeps.summary import Group
from auv_experiment.sweeps.table import SweepTable

_LONGEST = 28
_TELLING = ("kind", "preset")


def parameter_label(table: SweepTable, path: str) -> str:
    """Return the label of a parameter: its last word, or its whole path if two have the same last word."""
    if name := _name(table, path):
        return name
    words = [other.rpartition(".")[2] for other in table.study.parameters]
    word = path.rpartition(".")[2]
    return word if words.count(word) == 1 else path


def value_label(table: SweepTable, path: str, value: Any) -> str:
    """Return the label of a value of a parameter, as in the table."""
    return _value_labels(table, path).get(value) or _text(value)


def metric_label(table: SweepTable, name: str) -> str:
    """Return the label of a metric's axis; a truth value is a share."""
    if words := _name(table, name):
        return words
    unit = meaning_of(name).unit
    words = name.removesuffix(f"_{unit}").replace("_", " ") + (f" ({unit})" if unit else "")
    is_truth = any(isinstance(value, bool) for value in table.columns[name])
    return f"share of runs: {words}" if is_truth else words


def legend_title(table: SweepTable, paths: Sequence[str]) -> str:
    """Return the title of a legend: the parameters of its entries."""
    return ", ".join(parameter_label(table, path) for path in paths)


def group_label(table: SweepTable, group: Group) -> str:
    """Return a short label for the values of a group; `legend_title` has their parameters."""
    return ", ".join(value_label(table, path, value) for path, value in group.values.items())


def short_values(values: Sequence[Any]) -> list[str]:
    """Return a short text for each value; for mappings only their differences."""
    if not all(isinstance(value, Mapping) for value in values):
        return [_text(value) for value in values]
    leaves = [dict(_leaves(value)) for value in values]
    common = set.intersection(*(set(found.items()) for found in leaves)) if leaves else set()
    texts = [
        _cut(", ".join(_words(leaf) for leaf in found.items() if leaf not in common)) for found in leaves
    ]
    return texts if len(set(texts)) == len(texts) else [_text(value) for value in values]


def _name(table: SweepTable, key: str) -> str | None:
    label = (table.study.labels or {}).get(key)
    return None if label is None else label.name


def _value_labels(table: SweepTable, path: str) -> dict[Any, str]:
    """Return the labels of a parameter's values, by value as in the table."""
    values = (table.study.grid or {}).get(path, ())
    label = (table.study.labels or {}).get(path)
    texts = label.values if label is not None and label.values else short_values(values)
    return {table.as_in_column(path, value): text for value, text in zip(values, texts, strict=True)}


def _leaves(value: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, str]]:
    """Yield the dotted path and the text of every value in a mapping."""
    for key, inner in value.items():
        if isinstance(inner, Mapping) and inner:
            yield from _leaves(inner, f"{place}{key}.")
        else:
            yield f"{place}{key}", _text(inner)


def _words(leaf: tuple[str, str]) -> str:
    path, text = leaf
    key = path.rpartition(".")[2]
    return text if key in _TELLING else f"{key} {text}"


def _text(value: Any) -> str:
    return _cut(f"{value:g}" if is_number(value) else value if isinstance(value, str) else value_text(value))


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"
