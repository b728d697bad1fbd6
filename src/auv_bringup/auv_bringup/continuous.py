"""
Continuous time: the flocking law and the consensus evaluated inside every integration stage.

What the thesis's figures assume: single integrators that see each other and each other's estimates without
delay.  No packets, no filters, no control period; `period_s` is only the interval of the record.  The law
and the consensus are the agents' own.
"""

from __future__ import annotations

from collections.abc import Callable

from auv_bringup.compose import agent_configs
from auv_bringup.recording import Recording
from auv_bringup.scenario import Scenario
from auv_core.geometry import Vec3
from auv_core.integrate import State, rk4_step
from auv_flocking.agent import Agent


def run_continuous(scenario: Scenario, *, on_progress: Callable[[float], None] | None = None) -> Recording:
    """
    Fly a kinematic scenario in continuous time (RK4 with step `dt_s`) and return its recording.

    The state is [eta_1 ... eta_n, c_1 ... c_n] (m; NED).
    """
    agents = [Agent(config) for config in agent_configs(scenario)]
    ids = [vehicle.id for vehicle in scenario.vehicles]
    recording = Recording.empty(ids, scenario.tick_times())
    starts = [vehicle.position_ned_m or (0.0, 0.0, 0.0) for vehicle in scenario.vehicles]
    state: State = tuple(x for start in (*starts, *starts) for x in start)
    substeps = round(scenario.period_s / scenario.dt_s)
    count = len(agents)
    step = 0

    def derivative(t_s: float, state: State) -> State:
        velocities, rates = _rates(agents, t_s, _vectors(state))
        return tuple([x for vector in (*velocities, *rates) for x in vector])

    for tick in range(scenario.ticks + 1):
        vectors = _vectors(state)
        recording.position_ned_m[tick] = vectors[:count]
        velocities, rates = _rates(agents, tick * scenario.period_s, vectors)
        recording.velocity_body[tick] = [(*velocity, 0.0, 0.0, 0.0) for velocity in velocities]
        if tick == scenario.ticks:
            break
        recording.centre_ned_m[tick] = vectors[count:]
        recording.centre_velocity_ned_mps[tick] = rates
        recording.reference_velocity_ned_mps[tick] = velocities
        for _ in range(substeps):
            state = rk4_step(derivative, step * scenario.dt_s, state, scenario.dt_s)
            step += 1
        if on_progress is not None and tick % 100 == 99:
            on_progress((tick + 1) * scenario.period_s)
    recording.attitude_quat_wxyz[:] = (1.0, 0.0, 0.0, 0.0)
    return recording


def _vectors(state: State) -> list[Vec3]:
    return [(state[i], state[i + 1], state[i + 2]) for i in range(0, len(state), 3)]


def _rates(agents: list[Agent], t_s: float, vectors: list[Vec3]) -> tuple[list[Vec3], list[Vec3]]:
    """Return the velocities and the rates of the centre estimates of all vehicles (m/s; NED)."""
    count = len(agents)
    positions, centres = vectors[:count], vectors[count:]
    velocities, rates = [], []
    for index, agent in enumerate(agents):
        path = agent.path_point(t_s)
        others = (*positions[:index], *positions[index + 1 :])
        velocities.append(agent.velocity(path, positions[index], centres[index], others))
        heard = [*centres[:index], *centres[index + 1 :]]
        rates.append(agent.consensus_rate(positions[index], centres[index], heard))
    return velocities, rates
