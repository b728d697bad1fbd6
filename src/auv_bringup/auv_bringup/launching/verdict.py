"""The verdict on a completed flight from its recording: it decides the exit status."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from auv_core.cli.failures import DONE

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

LOST, COLLISION = 3, 4
"""Exit statuses of a run, in addition to those of all commands."""


def verdict(metrics: Mapping[str, Any], scenario: Scenario, mode: str) -> tuple[int, str]:
    """
    Return the exit status of a flight that reached its planned end, and one line why it is not 0.

    Parameters
    ----------
    metrics : mapping
        Metrics of the recording, as computed or as read from metrics.json.
    scenario : Scenario
        The scenario of the flight.
    mode : str
        'lockstep', 'realtime' or 'inprocess'; in real time ticks may be missing at the end.

    """
    recorded_s = metrics.get("duration_s")
    flown_s = scenario.ticks * scenario.period_s
    if mode == "lockstep" and recorded_s is not None and recorded_s < flown_s - 0.5 * scenario.period_s:
        return LOST, f"the bag holds {recorded_s:g} of {flown_s:g} s: the recorder fell behind"
    if metrics.get("collision"):
        return COLLISION, "two hulls touched"
    return DONE, ""
