"""A kinematic flock in continuous time: single integrators and consensus filters as one system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from auv_bringup.recording import Recording
from auv_bringup.scenario import Scenario
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_flocking.agent import Agent
from auv_flocking.flock_task import FlockTask


class FlockSystem:
    """The state is [eta_1 ... eta_n, c_1 ... c_n] (m; NED); an estimate starts where its vehicle does."""

    def __init__(self, scenario: Scenario, agents: Sequence[Agent]) -> None:
        self._tasks = [agent.task for agent in agents if isinstance(agent.task, FlockTask)]
        self._paths: list[Any] = [scenario.reference_of(index) for index in range(len(agents))]
        starts = [vehicle.position_ned_m or (0.0, 0.0, 0.0) for vehicle in scenario.vehicles]
        self.start: State = tuple(x for start in (*starts, *starts) for x in start)

    def derivative(self, t_s: float, state: State) -> State:
        """Return the velocities and the rates of the estimates (m/s; NED)."""
        velocities, rates = self._rates(t_s, _vectors(state))
        return tuple([x for vector in (*velocities, *rates) for x in vector])

    def settled(self, state: State) -> State:
        """Return `state` itself."""
        return state

    def record(self, recording: Recording, tick: int, t_s: float, state: State) -> None:
        """Write positions, velocities and estimates into row `tick`."""
        count = len(self._tasks)
        vectors = _vectors(state)
        velocities, rates = self._rates(t_s, vectors)
        recording.position_ned_m[tick] = vectors[:count]
        recording.velocity_body[tick] = [(*velocity, 0.0, 0.0, 0.0) for velocity in velocities]
        recording.attitude_quat_wxyz[tick] = (1.0, 0.0, 0.0, 0.0)
        if tick < recording.n_ticks:
            recording.centre_ned_m[tick] = vectors[count:]
            recording.centre_velocity_ned_mps[tick] = rates
            recording.reference_velocity_ned_mps[tick] = velocities

    def _rates(self, t_s: float, vectors: list[Vec3]) -> tuple[list[Vec3], list[Vec3]]:
        count = len(self._tasks)
        positions, centres = vectors[:count], vectors[count:]
        velocities, rates = [], []
        for index, task in enumerate(self._tasks):
            path = self._paths[index].at(t_s)
            others = (*positions[:index], *positions[index + 1 :])
            velocities.append(task.velocity(path, positions[index], centres[index], others))
            heard = [*centres[:index], *centres[index + 1 :]]
            rates.append(task.consensus_rate(positions[index], centres[index], heard))
        return velocities, rates


def _vectors(state: State) -> list[Vec3]:
    return [(state[i], state[i + 1], state[i + 2]) for i in range(0, len(state), 3)]
