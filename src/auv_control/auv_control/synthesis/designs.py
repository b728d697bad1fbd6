"""
The H-infinity laws of this package: plants, scales, and the presets with their gains.

Scales decide how stiff a law is. Where laws are compared, their stiffness is equal: `_matched` changes one
scale until the feedback has the required gain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.optimize import brentq

import auv_control.controllers
import auv_core.models
from auv_control.synthesis.h_infinity import (
    Plant,
    Synthesis,
    Weights,
    axis_plant,
    feedback,
    riccati_solution,
    synthesise,
    velocity_plant,
)

DIGITS = 8
FORMATION_STIFFNESS = {"surge": 100.0, "sway": 100.0, "heave": 150.0, "yaw": 30.0}
"""F_e of the formation law (N/m, N m/rad): K_D lambda of the adaptive law with its default gains."""
VELOCITY_GAIN_NSPM = 300.0
"""F_nu of the velocity law (N s/m): K_p of `velocity_pi`."""

_FORMATION_WEIGHTS = Weights(integral_ms=4.0)
_FORMATION_YAW_WEIGHTS = Weights(integral_ms=4.0, force_n=9.0, disturbance_n=6.0, speed_mps=0.01)
_VELOCITY_WEIGHTS = Weights(position_m=0.8)
_COMMAND = "./scripts/synthesise_h_infinity"
_LOG_SCALES = (-5.0, 7.0)


@dataclass(frozen=True)
class Design:
    """A preset: its name, the law's kind, the plant, scales and syntheses of the axes, the parameters."""

    preset: str
    kind: str
    plant: str
    weights: dict[str, Weights]
    axes: dict[str, Synthesis]
    params: dict[str, Any]

    @property
    def file(self) -> Path:
        """The file of the preset."""
        return Path(str(auv_control.controllers.__file__)).parent / f"presets/{self.preset}.yaml"

    @property
    def text(self) -> str:
        """The preset as YAML."""
        lines = [
            f"# H-infinity state feedback for the plant {self.plant}; written by {_COMMAND}.",
            *(
                f"# {names}: " + ", ".join(f"{key} {value:.6g}" for key, value in asdict(weights).items())
                for names, weights in self.weights.items()
            ),
            f"kind: {self.kind}",
            "params:",
            *(f"  {key}: {value}" for key, value in self.params.items()),
        ]
        return "\n".join(lines) + "\n"


def designs() -> tuple[Design, ...]:
    """Return every design, computed."""
    return _path_design(), _formation_design(), _velocity_design()


def _path_design() -> Design:
    """Return the design of `h_infinity` for thesis Table 2.1."""
    weights, numbers = Weights(), _numbers_of("table_2_1")
    axes = {
        name: synthesise(axis_plant(*_axis(numbers, axis), weights), weights.margin)
        for axis, name in enumerate(("surge", "sway"))
    }
    return Design(
        "h_infinity_table_2_1", "h_infinity", "table_2_1", {"all axes": weights}, axes, _axis_params(axes)
    )


def _formation_design() -> Design:
    """Return the design of `formation_h_infinity` for thesis Table 3.1."""
    numbers = _numbers_of("table_3_1")
    weights, axes = {}, {}
    for axis, (name, stiffness) in enumerate(FORMATION_STIFFNESS.items()):
        plant_of = partial(axis_plant, *_axis(numbers, axis))
        first = _FORMATION_YAW_WEIGHTS if name == "yaw" else _FORMATION_WEIGHTS
        weights[name] = _matched(plant_of, first, "position_m", (1, stiffness))
        axes[name] = synthesise(plant_of(weights[name]), first.margin)
    return Design(
        "formation_h_infinity_table_3_1",
        "formation_h_infinity",
        "table_3_1",
        weights,
        axes,
        _axis_params(axes),
    )


def _velocity_design() -> Design:
    """Return the design of `velocity_h_infinity` for ODIN, whose axes are equal."""
    numbers = _numbers_of("odin")
    hull = (
        numbers["mass_kg"] + numbers["added_mass"][0],
        numbers["linear_damping"][0],
        numbers["quadratic_damping"][0],
    )
    plant_of = partial(velocity_plant, *hull)
    weights = _matched(plant_of, _VELOCITY_WEIGHTS, "velocity_mps", (1, VELOCITY_GAIN_NSPM))
    axis = synthesise(plant_of(weights), weights.margin)
    params = {
        "gain": _rounded(axis.gain[0]),
        "riccati": _rounded(axis.riccati[np.triu_indices(2)]),
        "gamma": _rounded([axis.gamma])[0],
        "achieved_norm": _rounded([axis.norm_hamiltonian])[0],
    }
    return Design(
        "velocity_h_infinity_odin",
        "velocity_h_infinity",
        "odin",
        {"all axes": weights},
        {"velocity": axis},
        params,
    )


def _matched(
    plant_of: Callable[[Weights], Plant], weights: Weights, scale: str, wanted: tuple[int, float]
) -> Weights:
    """Return the weights with one scale changed until an element of F (its index, its value) is as wanted."""
    index, value = wanted
    gamma = weights.margin * weights.disturbance_n / weights.force_n

    def excess(log_scale: float) -> float:
        plant = plant_of(replace(weights, **{scale: float(np.exp(log_scale))}))
        riccati = riccati_solution(plant, gamma)
        if riccati is None:
            raise ValueError(f"{scale}: no feedback has a gain of {value!r}")
        return float(feedback(plant, riccati)[0, index]) - value

    return replace(weights, **{scale: _rounded([np.exp(brentq(excess, *_LOG_SCALES))])[0]})


def _numbers_of(preset: str) -> dict[str, Any]:
    file = Path(str(auv_core.models.__file__)).parent / f"presets/{preset}.yaml"
    numbers: dict[str, Any] = yaml.safe_load(file.read_text(encoding="utf-8"))["params"]
    return numbers


def _axis(numbers: dict[str, Any], axis: int) -> tuple[float, float, float]:
    """Return mass and damping of one axis of a hull with four degrees of freedom."""
    return numbers["inertia"][axis], numbers["linear_damping"][axis], numbers["quadratic_damping"][axis]


def _axis_params(axes: dict[str, Synthesis]) -> dict[str, Any]:
    """Return the parameters of a law with a feedback per axis, rounded to the digits of a preset."""
    upper = np.triu_indices(3)
    return {
        **{f"{name}_gain": _rounded(axis.gain[0]) for name, axis in axes.items()},
        **{f"{name}_riccati": _rounded(axis.riccati[upper]) for name, axis in axes.items()},
        "gamma": _rounded([axis.gamma for axis in axes.values()]),
        "achieved_norm": _rounded([axis.norm_hamiltonian for axis in axes.values()]),
    }


def _rounded(values: Iterable[Any]) -> list[float]:
    return [float(f"{float(value):.{DIGITS}g}") for value in values]
