"""Every metric of a run."""

from __future__ import annotations

from auv_experiment.metrics.descriptions import MEANINGS
from from_code.markdown import code, table


def metrics() -> str:
    """Return all metrics."""
    rows = [(code(key), meaning.unit or "–", meaning.words) for key, meaning in MEANINGS.items()]
    return table(("metric", "unit", "meaning"), rows)
