"""Flights of chapter 3 for its tests: a scenario with changes, or one vehicle alone; each flies once."""

import math
from functools import cache

import numpy as np

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.formations.errors import errors, formation_metrics
from auv_experiment.scenario.loading import load_scenario

ORIGIN = (0.0, 0.0, 0.0)
FLAT = "frame: flat, coriolis: false"
LAW = "agent.controller.params"
FIXED = (
    "inertia_adaptation: [0, 0, 0, 0], linear_adaptation: [0, 0, 0, 0], quadratic_adaptation: [0, 0, 0, 0]"
)
PD = f"{FIXED}, initial_ratio: 0.0, box: false"
GROUPED = "agent.controller.preset=adaptive_thesis_grouped_gamma"


class Flight:
    """A scenario, what happened in it, and its formation metrics."""

    def __init__(self, scenario):
        self.scenario = scenario
        self.recording = run_in_process(scenario)
        self.metrics = formation_metrics(self.recording, scenario)
        self.t_s = self.recording.t_s

    def error(self, vehicle=0):
        """Return the (K + 1, 4) path minus actual of a vehicle."""
        return errors(self.recording, self.scenario, vehicle)

    def rms_m(self, after_s, vehicle=0):
        late = self.error(vehicle)[self.t_s >= after_s][:, :3]
        return math.sqrt((late**2).sum(axis=1).mean())

    def estimate(self, name, t_s, vehicle=0):
        """Return an estimate by name at an instant."""
        tick = min(round(t_s / self.scenario.period_s), self.recording.n_ticks - 1)
        names = self.scenario.agent.controller.params.names
        return float(self.recording.law_state[tick, vehicle, names.index(name)])

    def largest(self, quantity, after_s=-1.0):
        return np.abs(np.asarray(quantity)[self.t_s[: len(quantity)] > after_s]).max(axis=0)


@cache
def fly(name, *overrides, dt_s=0.05, duration_s=None):
    """Fly a scenario with records at every step."""
    changed = [f"dt_s={dt_s}", f"period_s={dt_s}", *overrides]
    return Flight(load_scenario(name, overrides=changed, duration_s=duration_s))


def alone(path="circle", *, radius_m=10.0, rate_radps=0.01, start=ORIGIN, model=FLAT, heading="fixed"):
    """Return the override that leaves one vehicle, on a path of its own."""
    more = f", depth_m: 10.0, heading: {heading}" if path == "circle" else ""
    return (
        f"vehicles=[{{id: auv_1, model: {{preset: table_3_1, params: {{{model}}}}}, "
        f"position_ned_m: {list(start)}, reference: {{kind: {path}, "
        f"params: {{radius_m: {radius_m}, rate_radps: {rate_radps}{more}}}}}}}]"
    )


def law(words):
    """Return the override of the law's parameters, over those of the scenario's preset."""
    return f"{LAW}={{{words}}}"
