"""Metrics as text: unit, meaning and digits, also as a table for a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from auv_experiment.metrics import Meaning
from auv_experiment.metrics.descriptions import MEANINGS, family_meaning
from auv_experiment.metrics.own import own_meaning

_WIDEST = 32
_CAUSES = ("packet_loss_", "safe_commands_")
_TOLD_BEFORE = ("scenario", "seed", "mode", "vehicles")


def shown_metrics(metrics: dict[str, Any]) -> Iterator[tuple[str, Meaning]]:
    """Yield the keys of `metrics` and their meanings: in the order of `MEANINGS`, then the others."""
    for key in [*MEANINGS, *(key for key in metrics if key not in MEANINGS)]:
        if key in metrics:
            yield key, meaning_of(key)


def meaning_of(key: str) -> Meaning:
    """Return the meaning of a metric; for an own metric whose file is missing, the words of its key."""
    meaning = MEANINGS.get(key) or family_meaning(key) or own_meaning(key)
    return meaning or Meaning("", key.replace("_", " "), 4)


def value_text(value: Any, digits: int) -> str:
    """Return a metric as text; a dash if it does not exist."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{digits}f}"
    if isinstance(value, list):
        return ", ".join(value_text(item, digits) for item in value) or "none"
    return str(value)


def metrics_table(metrics: dict[str, Any]) -> str:
    """
    Return one line per metric that exists: value, unit, meaning; values aligned at the right.

    Long values, and causes that did not occur, are only in metrics.json and the report.
    """
    rows = [
        (value_text(metrics[key], meaning.digits), meaning.unit, meaning.words)
        for key, meaning in shown_metrics(metrics)
        if metrics[key] is not None
        and key not in _TOLD_BEFORE
        and not (key.startswith(_CAUSES) and metrics[key] == 0)
    ]
    rows = [row for row in rows if len(row[0]) <= _WIDEST]
    value_width = max((len(value) for value, _, _ in rows), default=0)
    unit_width = max((len(unit) for _, unit, _ in rows), default=0)
    return "\n".join(f"{value:>{value_width}} {unit:<{unit_width}}  {words}" for value, unit, words in rows)
