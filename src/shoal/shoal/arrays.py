"""A recording with labels: meaning, unit, frame and axes of each array."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.models import make_model
from auv_experiment.recording import FORMAT_VERSION, Recording
from auv_experiment.scenario.loading import scenario_to_yaml

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from auv_experiment.scenario.schema import Scenario


class Meaning(NamedTuple):
    """Axes, unit, frame and description of an array."""

    dims: tuple[str, ...]
    units: str
    frame: str
    words: str


_NED = ("north", "east", "down")
LABELS: dict[str, tuple[str, ...]] = {
    "axis": _NED,
    "quaternion": ("w", "x", "y", "z"),
    "rate": ("u", "v", "w", "p", "q", "r"),
    "effort": ("X", "Y", "Z", "K", "M", "N"),
    "moment": (*_NED, *(f"{each}_rate" for each in _NED)),
    "other_moment": (*_NED, *(f"{each}_rate" for each in _NED)),
    "contact_key": ("tick", "address"),
    "contact_value": ("range_m", "bearing_rad", "elevation_rad"),
    "sent_key": ("tick", "source", "sequence"),
    "received_key": ("tick", "source", "destination", "sequence"),
    "event_key": ("tick", "outcome", "source", "destination", "sequence", "size_bytes"),
    "event_value": ("start_s", "end_s", "snr_db"),
}
"""Labels of axes other than time, vehicle and rows."""

_NOW = ("time", "vehicle")
_OTHERS = ("time", "vehicle", "neighbour")
MEANINGS: dict[str, Meaning] = {
    "position_ned_m": Meaning((*_NOW, "axis"), "m", "map_ned", "true position of the hull's centre"),
    "attitude_quat_wxyz": Meaning((*_NOW, "quaternion"), "1", "body FRD to NED", "true attitude"),
    "velocity_body": Meaning((*_NOW, "rate"), "m/s, rad/s", "body FRD", "true velocity and turn rates"),
    "command": Meaning((*_NOW, "effort"), "N, N m", "body FRD", "wrench asked of the actuators"),
    "actuator_command": Meaning(
        (*_NOW, "actuator"), "of the actuator", "", "what was asked of each actuator with a state"
    ),
    "actuator_output": Meaning((*_NOW, "actuator"), "of the actuator", "", "its output"),
    "reference_velocity_ned_mps": Meaning((*_NOW, "axis"), "m/s", "map_ned", "velocity commanded by the law"),
    "centre_ned_m": Meaning((*_NOW, "axis"), "m", "map_ned", "own estimate of the flocking centre"),
    "centre_velocity_ned_mps": Meaning((*_NOW, "axis"), "m/s", "map_ned", "rate of that estimate"),
    "law_state": Meaning((*_NOW, "memory"), "of the law", "of the law", "state of the law"),
    "holding": Meaning(_NOW, "1", "", "cause of the safe command, 0 if the law acted"),
    "neighbour_position_ned_m": Meaning((*_OTHERS, "axis"), "m", "own navigation", "estimate of a neighbour"),
    "neighbour_velocity_ned_mps": Meaning((*_OTHERS, "axis"), "m/s", "own navigation", "its velocity"),
    "neighbour_covariance": Meaning(
        (*_OTHERS, "moment", "other_moment"), "m^2, m^2/s, m^2/s^2", "own navigation", "its covariance"
    ),
    "neighbour_age_s": Meaning(_OTHERS, "s", "", "age of the newest packet in the estimate"),
    "neighbour_sonar_age_s": Meaning(_OTHERS, "s", "", "time since the sonar saw the neighbour"),
    "nav_position_ned_m": Meaning(
        (*_NOW, "axis"), "m", "map_ned", "position by the vehicle's own navigation"
    ),
    "nav_position_sd_m": Meaning(_NOW, "m", "", "its standard deviation per horizontal axis"),
    "contacts": Meaning(("contact", "contact_key"), "1", "", "time and observer of a sonar contact"),
    "contact_values": Meaning(("contact", "contact_value"), "m, rad, rad", "body FRD", "sonar contact"),
    "sent": Meaning(("sent_packet", "sent_key"), "1", "", "packets passed to modems"),
    "received": Meaning(("reception", "received_key"), "1", "", "packets that arrived"),
    "delay_s": Meaning(("reception",), "s", "", "start of transmission to end of reception"),
    "events": Meaning(("event", "event_key"), "1", "", "the acoustic log"),
    "event_values": Meaning(
        ("event", "event_value"), "s, s, dB", "", "first and last moment of the signal, SNR"
    ),
    "lost_at_s": Meaning(("vehicle",), "s", "", "time at which the vehicle's computer was lost"),
}
"""Every array of a recording except `vehicle_ids` and `t_s`, which are the coordinates vehicle and time."""

_NO_DECISION = -1


def to_xarray(recording: Recording, scenario: Scenario, mode: str) -> xr.Dataset:
    """
    Return a recording as a Dataset.

    Commands have as many rows as states: the last row, for which there is no command, is NaN (-1 in
    `holding`). Arrays of neighbours are left out if there are no neighbour estimates, those of actuators if
    no vehicle has one with a state. The axis of actuators has their names if all vehicles have the same.
    """
    import xarray as xr

    names = list(recording.vehicle_ids)
    variables = {}
    for name, meaning in MEANINGS.items():
        if "neighbour" in meaning.dims and not recording.has_neighbours:
            continue
        if "actuator" in meaning.dims and recording.actuator_output.shape[-1] == 0:
            continue
        values = _as_long_as_states(getattr(recording, name), meaning, len(recording.t_s))
        attributes = {"units": meaning.units, "long_name": meaning.words}
        if meaning.frame:
            attributes["frame"] = meaning.frame
        variables[name] = (meaning.dims, values, attributes)
    if scenario.kinematic:
        dims, values, attributes = variables["command"]
        words = {
            "units": "m/s, rad/s",
            "frame": "map_ned",
            "long_name": "commanded velocity (X, Y, Z) and yaw rate (N)",
        }
        variables["command"] = (dims, values, {**attributes, **words})
    actuators = [make_model(vehicle.model).actuators for vehicle in scenario.vehicles]
    units = {each.unit for those in actuators for each in those}
    if len(units) == 1:
        for name in ("actuator_command", "actuator_output"):
            variables[name][2]["units"] = next(iter(units))
    used = {dim for dims, _, _ in variables.values() for dim in dims}
    coordinates: dict[str, Any] = {dim: list(LABELS[dim]) for dim in LABELS if dim in used}
    coordinates["time"] = ("time", recording.t_s, {"units": "s", "long_name": "scenario time"})
    coordinates["vehicle"] = names
    if "neighbour" in used:
        coordinates["neighbour"] = names
    if "actuator" in used and len({those for those in actuators if those}) == 1:
        coordinates["actuator"] = [each.name for each in max(actuators, key=len)]
    about = {
        "title": scenario.title,
        "scenario": scenario.name,
        "seed": scenario.seed,
        "mode": mode,
        "period_s": scenario.period_s,
        "format_version": FORMAT_VERSION,
        "scenario_yaml": scenario_to_yaml(scenario),
    }
    return xr.Dataset(variables, coordinates, about)


def to_pandas(recording: Recording, scenario: Scenario, mode: str) -> pd.DataFrame:
    """Return the data of every vehicle: a row for each time and vehicle, a column for each number."""
    import pandas as pd

    dataset = to_xarray(recording, scenario, mode)
    index = pd.MultiIndex.from_product(
        [recording.t_s, list(recording.vehicle_ids)], names=["time_s", "vehicle"]
    )
    columns: dict[str, NDArray[Any]] = {}
    for name, variable in dataset.data_vars.items():
        if variable.dims[:2] != _NOW or variable.ndim > 3 or "neighbour" in variable.dims:
            continue
        if variable.ndim == 2:
            columns[str(name)] = variable.to_numpy().reshape(-1)
            continue
        labels = LABELS.get(str(variable.dims[2])) or range(variable.shape[2])
        for position, label in enumerate(labels):
            columns[f"{name}.{label}"] = variable.to_numpy()[:, :, position].reshape(-1)
    table = pd.DataFrame(columns, index=index)
    table.attrs = {"scenario": scenario.name, "seed": scenario.seed, "mode": mode}
    return table


def _as_long_as_states(values: NDArray[Any], meaning: Meaning, n_states: int) -> NDArray[Any]:
    """Return an array with a row for every state; the last row is empty for arrays of commands."""
    if meaning.dims[0] != "time" or len(values) == n_states:
        return values
    empty = _NO_DECISION if values.dtype == np.int64 else np.nan
    return np.concatenate([values, np.full((n_states - len(values), *values.shape[1:]), empty, values.dtype)])
