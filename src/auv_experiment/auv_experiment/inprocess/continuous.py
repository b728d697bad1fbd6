"""
Continuous time: the laws evaluated inside every integration stage.

This is the assumption of the thesis's figures: vehicles know each other's positions and estimates without
delay. There are no packets, no filters and no control period; `period_s` is only the interval of the record.
Laws, consensus and equations of motion are those of the agents and vehicles. If the compiled loop of
`fleet_loop` supports the laws and vehicles of a flock, it flies the flock, with the same numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from auv_core.compiled import is_compiling
from auv_core.integrate import State, rk4_step
from auv_experiment.compose import agent_configs
from auv_experiment.inprocess.fleet import fly_fleet, has_compiled_form
from auv_experiment.inprocess.flock_system import FlockSystem
from auv_experiment.inprocess.motion_system import MotionSystem
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent


class System(Protocol):
    """The equations of all vehicles and laws of a scenario as one."""

    start: State

    def derivative(self, t_s: float, state: State) -> State:
        """Return the rate of change of `state`."""

    def settled(self, state: State) -> State:
        """Return `state` projected to allowed values, after a step."""

    def record(self, recording: Recording, tick: int, t_s: float, state: State) -> None:
        """Write `state` into row `tick`, and the laws' outputs unless it is the last row."""


def run_continuous(scenario: Scenario, *, on_progress: Callable[[float], None] | None = None) -> Recording:
    """
    Fly a scenario in continuous time (RK4 with step `dt_s`) and return its recording.

    Raises
    ------
    DivergedError
        If a motion has no finite solution.

    """
    ids = [vehicle.id for vehicle in scenario.vehicles]
    recording = Recording.empty(ids, scenario.tick_times(), has_neighbours=False)
    if is_compiling() and has_compiled_form(scenario):
        fly_fleet(scenario, recording, on_progress)
    else:
        _integrate(scenario, recording, on_progress)
    recording.nav_position_ned_m[:] = recording.position_ned_m[:-1]
    recording.nav_position_sd_m[:] = 0.0
    return recording


def _integrate(scenario: Scenario, recording: Recording, on_progress: Callable[[float], None] | None) -> None:
    """Fly vehicle by vehicle, with any laws."""
    agents = [Agent(config) for config in agent_configs(scenario)]
    system: System
    if scenario.follows == "velocity":
        system = FlockSystem(scenario, agents)
    else:
        system = MotionSystem(scenario, agents, recording)
    state = system.start
    substeps = round(scenario.period_s / scenario.dt_s)
    step = 0
    for tick in range(scenario.ticks):
        system.record(recording, tick, tick * scenario.period_s, state)
        for _ in range(substeps):
            state = system.settled(rk4_step(system.derivative, step * scenario.dt_s, state, scenario.dt_s))
            step += 1
        if on_progress is not None and tick % 100 == 99:
            on_progress((tick + 1) * scenario.period_s)
    system.record(recording, scenario.ticks, scenario.ticks * scenario.period_s, state)
