"""The metrics of a run as a table for a terminal, in the words and with the digits of the report."""

from __future__ import annotations

from typing import Any

from auv_experiment.metrics.descriptions import shown_metrics, value_text

_WIDEST = 32
_CAUSES = ("packet_loss_", "safe_commands_")
_TOLD_BEFORE = ("scenario", "seed", "mode", "vehicles")


def metrics_table(metrics: dict[str, Any]) -> str:
    """
    Return one line per metric that exists: value, unit, meaning; values aligned at the right.

    Values of more than a few words or numbers, and causes of which there was no case, are left to
    metrics.json and the report.
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
