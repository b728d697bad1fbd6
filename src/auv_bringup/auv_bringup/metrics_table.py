"""The metrics of a run as a table for a terminal, in the words and with the digits of the report."""

from __future__ import annotations

from typing import Any

from auv_bringup import report


def metrics_table(metrics: dict[str, Any]) -> str:
    """Return one line per metric that exists: value, unit, meaning; values aligned at the right."""
    told_before = ("scenario", "seed", "mode", "vehicles")
    rows = []
    for key in [*report._ROWS, *(key for key in metrics if key not in report._ROWS)]:
        if metrics.get(key) is None or key in told_before:
            continue
        row = report._ROWS.get(key, report._Row("", key.replace("_", " ")))
        rows.append((report._value_text(metrics[key], row.digits), row.unit, row.words))
    value_width = max((len(value) for value, _, _ in rows), default=0)
    unit_width = max((len(unit) for _, unit, _ in rows), default=0)
    return "\n".join(f"{value:>{value_width}} {unit:<{unit_width}}  {words}" for value, unit, words in rows)
