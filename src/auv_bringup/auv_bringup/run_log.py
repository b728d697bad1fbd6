"""Takes down what happens in an in-process run, tick by tick, into a recording."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from auv_bringup.recording import Recording, law_states
from auv_bringup.scenario import Scenario
from auv_core.messages import AcousticEvent, Command, Inbox, Packet, VehicleState, command_numbers
from auv_flocking.agent import Agent
from auv_flocking.estimates import AGE, COVARIANCE, POSITION, SONAR_AGE, VELOCITY, Estimates

_ROWS = ("sent", "received", "delay_s", "contacts", "contact_values", "events", "event_values")
_BLOCK_TICKS = 256
_NOWHERE = (math.nan, math.nan, math.nan)


class RunLog:
    """
    Collects a recording. What comes at every tick is kept in lists and written into the arrays by the block:
    one assignment for many ticks costs little more than one for a single tick.
    """

    def __init__(self, scenario: Scenario) -> None:
        ids = [vehicle.id for vehicle in scenario.vehicles]
        self._recording = Recording.empty(ids, scenario.tick_times())
        self._law_states: dict[tuple[int, int], Sequence[float]] = {}
        self._rows: dict[str, list[Sequence[float]]] = {name: [] for name in _ROWS}
        self._block: defaultdict[str, list[Any]] = defaultdict(list)
        self._known: list[tuple[int, int, Estimates]] = []
        self._written = 0

    def states(self, states: Sequence[VehicleState]) -> None:
        """Note the true states, which come after the last tick, too."""
        block = self._block
        block["position_ned_m"].append([state.position for state in states])
        block["attitude_quat_wxyz"].append([state.attitude for state in states])
        block["velocity_body"].append([state.nu for state in states])

    def tick(
        self,
        tick: int,
        states: Sequence[VehicleState],
        navs: Sequence[VehicleState],
        agents: Sequence[Agent],
        commands: Sequence[Command],
    ) -> None:
        """Note the true states, what the vehicles believe of themselves, and what the agents made of it."""
        if tick - self._written == _BLOCK_TICKS:
            self._write(tick)
        self.states(states)
        block = self._block
        block["nav_position_ned_m"].append([nav.position for nav in navs])
        block["nav_position_sd_m"].append([nav.position_sd_m for nav in navs])
        block["command"].append([command_numbers(command) for command in commands])
        block["reference_velocity_ned_mps"].append([agent.reference.velocity for agent in agents])
        block["holding"].append([bool(agent.holding) for agent in agents])
        block["centre_ned_m"].append([agent.centre if agent.flocks else _NOWHERE for agent in agents])
        block["centre_velocity_ned_mps"].append(
            [agent.centre_rate if agent.flocks else _NOWHERE for agent in agents]
        )
        for index, agent in enumerate(agents):
            if agent.law_state:
                self._law_states[tick, index] = agent.law_state
            if agent.neighbours.addresses:
                self._known.append((tick, index, agent.neighbours))

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
        self._write(r.n_ticks)
        r.law_state = law_states(self._law_states, r.n_ticks, r.n_vehicles)
        for name, rows in self._rows.items():
            empty = getattr(r, name)
            setattr(r, name, np.array(rows, dtype=empty.dtype).reshape(-1, *empty.shape[1:]))
        return r

    def _write(self, tick: int) -> None:
        """Write the block that ends before `tick` into the arrays."""
        r, start = self._recording, self._written
        for name, rows in self._block.items():
            getattr(r, name)[start : start + len(rows)] = rows
        self._block.clear()
        self._written = tick
        if not self._known:
            return
        who = np.array(
            [(at, index, address - 1) for at, index, known in self._known for address in known.addresses]
        )
        place = (who[:, 0], who[:, 1], who[:, 2])
        numbers = np.concatenate([known.rows for _, _, known in self._known])
        r.neighbour_position_ned_m[place] = numbers[:, POSITION:VELOCITY]
        r.neighbour_velocity_ned_mps[place] = numbers[:, VELOCITY:COVARIANCE]
        r.neighbour_covariance[place] = numbers[:, COVARIANCE:AGE].reshape(-1, 6, 6)
        r.neighbour_age_s[place] = numbers[:, AGE]
        r.neighbour_sonar_age_s[place] = numbers[:, SONAR_AGE]
        self._known.clear()
