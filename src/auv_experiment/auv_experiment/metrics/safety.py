"""Metrics of holding: how often agents gave the safe command, and why."""

from __future__ import annotations

from auv_experiment.recording import Recording
from auv_flocking.holding import CAUSES


def safe_command_metrics(recording: Recording) -> dict[str, float | int | None]:
    """Return how often agents gave the safe command instead of the law's: a key for each of `CAUSES`."""
    holding = recording.holding
    counts = {
        f"safe_commands_{cause.replace(' ', '_')}": int((holding == number).sum())
        for number, cause in enumerate(CAUSES, start=1)
    }
    return {"safe_command_ratio": float((holding > 0).mean()) if holding.size else None, **counts}
