"""
Effort of vehicles that steer with fins and a propeller.

It counts outputs of actuators, which act after their delays: squared angles of all fins, and turns of all
propellers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from auv_core.models import make_model
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_RPM_SECONDS = 60.0


def fin_effort_metrics(recording: Recording, scenario: Scenario) -> dict[str, float]:
    """Return the effort of all vehicles with fins; nothing without fins."""
    if not recording.actuator_output.shape[2]:
        return {}
    fins_rad, propellers_rpm = (_outputs(recording, scenario, unit) for unit in ("rad", "rpm"))
    if not fins_rad.shape[1]:
        return {}
    period_s = scenario.period_s
    return {
        "fin_effort_rad2s": float(np.nansum(fins_rad**2) * period_s),
        "propeller_turns": float(np.nansum(np.abs(propellers_rpm)) * period_s / _RPM_SECONDS),
    }


def _outputs(recording: Recording, scenario: Scenario, unit: str) -> FloatArray:
    """Return the (K, number) outputs of all actuators with a unit, at the ends of the control periods."""
    found = [
        (index, column)
        for index, vehicle in enumerate(scenario.vehicles)
        for column, actuator in enumerate(make_model(vehicle.model).actuators)
        if actuator.unit == unit
    ]
    vehicles, columns = [index for index, _ in found], [column for _, column in found]
    return recording.actuator_output[1:][:, vehicles, columns]
