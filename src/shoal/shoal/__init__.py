"""
Shoal: groups of underwater vehicles that communicate only through water.

Examples
--------
>>> import shoal
>>> scenario = shoal.load("flock_acoustic")
>>> scenario["duration_s"] = 5.0
>>> result = shoal.run(scenario, seed=3)
>>> result.metrics["collision"]
False

"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from auv_core.params import ConfigError
    from auv_experiment.results import ResultsError
    from auv_sim.vehicle import DivergedError
    from shoal.result import Result
    from shoal.result import open_result as open  # noqa: A004  shoal.open("results/...")
    from shoal.runs import run, sweep
    from shoal.scenario import Scenario, load, scenarios
    from shoal.simulation import Simulation
    from shoal.summaries import summarise

__all__ = [
    "ConfigError",
    "DivergedError",
    "Result",
    "ResultsError",
    "Scenario",
    "Simulation",
    "__version__",
    "load",
    "open",
    "run",
    "scenarios",
    "summarise",
    "sweep",
]

__version__ = "0.2.0.dev0"

_PLACES = {
    "ConfigError": "auv_core.params",
    "DivergedError": "auv_sim.vehicle",
    "Result": "shoal.result",
    "ResultsError": "auv_experiment.results",
    "Scenario": "shoal.scenario",
    "Simulation": "shoal.simulation",
    "load": "shoal.scenario",
    "open": "shoal.result:open_result",
    "run": "shoal.runs",
    "scenarios": "shoal.scenario",
    "summarise": "shoal.summaries",
    "sweep": "shoal.runs",
}
"""Modules of the names; each is imported at first use, so that the command starts quickly."""


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'shoal' has no attribute {name!r}")
    module, _, other = _PLACES[name].partition(":")
    value = getattr(importlib.import_module(module), other or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
