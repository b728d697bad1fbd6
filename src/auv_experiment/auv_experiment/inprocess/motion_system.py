"""Vehicles with laws that give a wrench, in continuous time: plants and laws as one system."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from auv_control.controllers import MotionView
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import VehicleState
from auv_core.models import HULL, make_continuous_model
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent
from auv_flocking.motion_task import MotionTask
from auv_sim.vehicle import check_finite


class _Member:
    """One vehicle: its place in the state, its plant, its law and its path."""

    def __init__(self, scenario: Scenario, index: int, agent: Agent) -> None:
        if not isinstance(agent.task, MotionTask):
            raise TypeError("a vehicle of a flock")
        vehicle = scenario.vehicles[index]
        self.name = vehicle.id
        self.agent = agent
        self.task: MotionTask = agent.task
        self.model = make_continuous_model(vehicle.model)
        self.plant_start: State = self.model.initial_state(
            vehicle.position_ned_m or (0.0, 0.0, 0.0), vehicle.heading_rad, vehicle.speed_mps
        )
        self.law_start: State = ()
        self.plant = slice(0, 0)
        self.memory = slice(0, 0)


class MotionSystem:
    """
    The state has, vehicle by vehicle, the state of the plant, actuators included, and that of the law.

    Every vehicle knows the true positions of the others.
    """

    def __init__(self, scenario: Scenario, agents: Sequence[Agent], recording: Recording) -> None:
        self._current = scenario.environment.current_ned_mps
        self._members = [_Member(scenario, index, agent) for index, agent in enumerate(agents)]
        positions = [(m.plant_start[0], m.plant_start[1], m.plant_start[2]) for m in self._members]
        start: list[float] = []
        for index, member in enumerate(self._members):
            view = self._view(index, 0.0, member.plant_start, positions)
            member.law_start = member.task.law.initial_state(view)
            middle = len(start) + len(member.plant_start)
            member.plant = slice(len(start), middle)
            member.memory = slice(middle, middle + len(member.law_start))
            start += (*member.plant_start, *member.law_start)
        self.start: State = tuple(start)
        longest = max(len(member.law_start) for member in self._members)
        recording.law_state = np.full((recording.n_ticks, len(agents), longest), np.nan)

    def derivative(self, t_s: float, state: State) -> State:
        """Return the rates of the plants and of the laws' states."""
        positions = self._positions(state)
        rates: list[float] = []
        for index, member in enumerate(self._members):
            plant = state[member.plant]
            tau, law_rate = member.task.law.evaluate(
                state[member.memory], self._view(index, t_s, plant, positions)
            )
            given = member.model.limited_command(tau)
            rates += member.model.derivative(plant, given, self._current)
            rates += law_rate
        return tuple(rates)

    def settled(self, state: State) -> State:
        """Return `state` with normalised quaternions and the laws' states within their limits."""
        settled: list[float] = []
        for member in self._members:
            settled += member.model.normalised(state[member.plant])
            if member.law_start:
                settled += member.task.law.constrained(state[member.memory])
        return tuple(settled)

    def record(self, recording: Recording, tick: int, t_s: float, state: State) -> None:
        """Write plants, wrenches, path velocities and the laws' states into row `tick`."""
        positions = self._positions(state)
        for index, member in enumerate(self._members):
            plant, memory = state[member.plant], state[member.memory]
            check_finite(plant, member.name, t_s)
            recording.position_ned_m[tick, index] = plant[:3]
            recording.attitude_quat_wxyz[tick, index] = plant[3:7]
            recording.velocity_body[tick, index] = plant[7:HULL]
            if tick == recording.n_ticks:
                continue
            view = self._view(index, t_s, plant, positions)
            recording.command[tick, index], _ = member.task.law.evaluate(memory, view)
            recording.reference_velocity_ned_mps[tick, index] = view.path.velocity if view.path else 0.0
            recording.law_state[tick, index, : len(memory)] = memory

    def _positions(self, state: State) -> list[Vec3]:
        starts = [member.plant.start for member in self._members]
        return [(state[i], state[i + 1], state[i + 2]) for i in starts]

    def _view(self, index: int, t_s: float, plant: State, positions: list[Vec3]) -> MotionView:
        member = self._members[index]
        x, y, z = plant[:3]
        qw, qx, qy, qz = plant[3:7]
        (u, v, w), (p, q, r) = plant[7:10], plant[10:HULL]
        nav = VehicleState(0, (x, y, z), (qw, qx, qy, qz), (u, v, w, p, q, r))
        others = (*positions[:index], *positions[index + 1 :])
        return member.task.view(t_s, nav, member.agent.path_point(t_s), others)
