"""Metrics of holding: how often agents gave the safe command, and why."""

from __future__ import annotations

from auv_experiment.recording import Recording
from auv_flocking.holding import CAUSES


def safe_command_metrics(recording: Recording) -> dict[str, float | int | None]:
    """
    Return how often agents gave the safe command instead of the law's.

    ``safe_command_ratio`` is the share of the control ticks of all vehicles.
    ``safe_commands_stale_navigation`` and similar keys count these ticks by cause: one key for each of
    `auv_flocking.holding.CAUSES`.
    """
    holding = recording.holding
    counts = {
        f"safe_commands_{cause.replace(' ', '_')}": int((holding == number).sum())
        for number, cause in enumerate(CAUSES, start=1)
    }
    return {"safe_command_ratio": float((holding > 0).mean()) if holding.size else None, **counts}
