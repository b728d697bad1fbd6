"""A scenario in one process, without ROS: the same objects as the nodes, called in the same order."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from auv_core.compiled import use_compiler
from auv_core.messages import Command, Packet
from auv_experiment.compose import agent_configs, vehicle_configs
from auv_experiment.inprocess.continuous import run_continuous
from auv_experiment.inprocess.run_log import RunLog
from auv_experiment.recording import Recording
from auv_experiment.run_memory import check_memory
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent
from auv_sim.acoustics.medium import AcousticMedium
from auv_sim.vehicle import Vehicle

Progress = Callable[[float], None]

_COLLECT_EVERY = 100_000


def run_in_process(scenario: Scenario, *, on_progress: Progress | None = None) -> Recording:
    """
    Fly a scenario and return its recording.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario, sampled or continuous.
    on_progress : callable, optional
        Called now and then with the scenario time reached (s).

    Raises
    ------
    ConfigError
        When the run does not fit into the memory that is free.

    """
    check_memory(scenario)
    use_compiler()
    with _rare_collections():
        if scenario.sampling == "continuous":
            return run_continuous(scenario, on_progress=on_progress)
        return _run_sampled(scenario, on_progress)


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Let the garbage collector look rarely: a run makes many short-lived objects and no cycles of them."""
    usual = gc.get_threshold()
    gc.set_threshold(_COLLECT_EVERY, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


def _run_sampled(scenario: Scenario, on_progress: Progress | None) -> Recording:
    vehicles = [Vehicle(config) for config in vehicle_configs(scenario)]
    agents = [Agent(config) for config in agent_configs(scenario)]
    medium = AcousticMedium(scenario.medium_config)
    log = RunLog(scenario)
    states = [vehicle.state for vehicle in vehicles]
    navs = [vehicle.nav for vehicle in vehicles]
    for tick in range(scenario.ticks):
        inboxes = medium.exchange(tick, states)
        commands: list[Command] = []
        handed_over: dict[int, Sequence[Packet]] = {}
        for index, agent in enumerate(agents):
            command, packets = agent.step(tick * scenario.period_s, navs[index], inboxes[index])
            commands.append(command)
            handed_over[index + 1] = packets
        medium.transmit(handed_over, states)
        log.tick(tick, states, navs, agents, commands)
        log.water(tick, inboxes, handed_over, medium.take_events())
        states = [vehicle.step(command) for vehicle, command in zip(vehicles, commands, strict=True)]
        navs = [vehicle.nav for vehicle in vehicles]
        if on_progress is not None and tick % 100 == 99:
            on_progress((tick + 1) * scenario.period_s)
    log.last_states(states)
    return log.finished()
