"""A scenario in one process, without ROS: the same objects as the nodes, called in the same order."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from auv_bringup.compose import agent_configs, vehicle_configs
from auv_bringup.continuous import run_continuous
from auv_bringup.recording import Recording, law_states
from auv_bringup.scenario import Scenario
from auv_core.compiled import use_compiler
from auv_core.messages import AcousticEvent, Command, Inbox, Packet, VehicleState, command_numbers
from auv_flocking.agent import Agent
from auv_sim.acoustics.medium import AcousticMedium
from auv_sim.vehicle import Vehicle

Progress = Callable[[float], None]

_ROWS = ("sent", "received", "delay_s", "contacts", "contact_values", "events", "event_values")


def run_in_process(scenario: Scenario, *, on_progress: Progress | None = None) -> Recording:
    """
    Fly a scenario and return its recording.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario, sampled or continuous.
    on_progress : callable, optional
        Called now and then with the scenario time reached (s).

    """
    use_compiler()
    if scenario.sampling == "continuous":
        return run_continuous(scenario, on_progress=on_progress)
    vehicles = [Vehicle(config) for config in vehicle_configs(scenario)]
    agents = [Agent(config) for config in agent_configs(scenario)]
    medium = AcousticMedium(scenario.medium_config)
    log = _Log(scenario)
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
        log.tick(tick, states, agents, commands)
        log.navigation(tick, navs)
        log.water(tick, inboxes, handed_over, medium.take_events())
        states = [vehicle.step(command) for vehicle, command in zip(vehicles, commands, strict=True)]
        navs = [vehicle.nav for vehicle in vehicles]
        if on_progress is not None and tick % 100 == 99:
            on_progress((tick + 1) * scenario.period_s)
    log.states(scenario.ticks, states)
    return log.finished()


class _Log:
    """Collects a recording tick by tick."""

    def __init__(self, scenario: Scenario) -> None:
        ids = [vehicle.id for vehicle in scenario.vehicles]
        self._recording = Recording.empty(ids, scenario.tick_times())
        self._law_states: dict[tuple[int, int], Sequence[float]] = {}
        self._rows: dict[str, list[Sequence[float]]] = {name: [] for name in _ROWS}

    def states(self, tick: int, states: Sequence[VehicleState]) -> None:
        """Note the true states."""
        r = self._recording
        r.position_ned_m[tick] = [state.position for state in states]
        r.attitude_quat_wxyz[tick] = [state.attitude for state in states]
        r.velocity_body[tick] = [state.nu for state in states]

    def tick(
        self,
        tick: int,
        states: Sequence[VehicleState],
        agents: Sequence[Agent],
        commands: Sequence[Command],
    ) -> None:
        """Note the true states and what the agents made of the tick."""
        self.states(tick, states)
        r = self._recording
        r.command[tick] = [command_numbers(command) for command in commands]
        r.reference_velocity_ned_mps[tick] = [agent.reference.velocity for agent in agents]
        r.holding[tick] = [bool(agent.holding) for agent in agents]
        for index, agent in enumerate(agents):
            if agent.flocks:
                r.centre_ned_m[tick, index] = agent.centre
                r.centre_velocity_ned_mps[tick, index] = agent.centre_rate
            if agent.law_state:
                self._law_states[tick, index] = agent.law_state
            for estimate in agent.neighbours:
                other = estimate.address - 1
                r.neighbour_position_ned_m[tick, index, other] = estimate.position
                r.neighbour_velocity_ned_mps[tick, index, other] = estimate.velocity
                r.neighbour_covariance[tick, index, other] = estimate.covariance
                r.neighbour_age_s[tick, index, other] = estimate.age_s
                r.neighbour_sonar_age_s[tick, index, other] = estimate.sonar_age_s

    def navigation(self, tick: int, navs: Sequence[VehicleState]) -> None:
        """Note what the vehicles believe of themselves."""
        self._recording.nav_position_ned_m[tick] = [nav.position for nav in navs]
        self._recording.nav_position_sd_m[tick] = [nav.position_sd_m for nav in navs]

    def water(
        self,
        tick: int,
        inboxes: Sequence[Inbox],
        handed_over: dict[int, Sequence[Packet]],
        events: Sequence[AcousticEvent],
    ) -> None:
        """Note what went into the water and what came out of it."""
        rows = self._rows
        for packets in handed_over.values():
            rows["sent"].extend((packet.tick, packet.source, packet.sequence) for packet in packets)
        for address, inbox in enumerate(inboxes, start=1):
            for reception in inbox.receptions:
                packet = reception.packet
                rows["received"].append((tick, packet.source, address, packet.sequence))
                rows["delay_s"].append((reception.arrival_s - reception.sent_s,))
            for contact in inbox.contacts:
                rows["contacts"].append((tick, address))
                rows["contact_values"].append((contact.range_m, contact.bearing_rad, contact.elevation_rad))
        for e in events:
            rows["events"].append((tick, e.outcome, e.source, e.destination, e.sequence, e.size_bytes))
            rows["event_values"].append((e.start_s, e.end_s, e.snr_db))

    def finished(self) -> Recording:
        """Return the recording."""
        r = self._recording
        r.law_state = law_states(self._law_states, r.n_ticks, r.n_vehicles)
        for name, rows in self._rows.items():
            empty = getattr(r, name)
            setattr(r, name, np.array(rows, dtype=empty.dtype).reshape(-1, *empty.shape[1:]))
        return r
