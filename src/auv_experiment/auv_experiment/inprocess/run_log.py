"""Records an in-process run, tick by tick."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence

import numpy as np

from auv_core.messages import AcousticEvent, Command, Inbox, Numbers, Packet, VehicleState
from auv_core.stamp import nanoseconds, whole_nanoseconds_s
from auv_experiment.actuator_rows import ActuatorRows
from auv_experiment.inprocess.actuator_log import ActuatorLog
from auv_experiment.recording import FloatArray, Recording
from auv_experiment.recording_shapes import shapes_of
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent
from auv_flocking.holding import cause_number
from auv_flocking.neighbours.estimates import AGE, COVARIANCE, POSITION, SONAR_AGE, VELOCITY, Estimates

_ROWS = ("sent", "received", "delay_s", "contacts", "contact_values", "events", "event_values")
_BLOCK_TICKS = 32
_COLUMNS: dict[str, int | slice] = {
    "position_ned_m": slice(0, 3),
    "attitude_quat_wxyz": slice(3, 7),
    "velocity_body": slice(7, 13),
    "nav_position_ned_m": slice(13, 16),
    "nav_position_sd_m": 16,
    "command": slice(17, 23),
    "reference_velocity_ned_mps": slice(23, 26),
    "holding": 26,
    "centre_ned_m": slice(27, 30),
    "centre_velocity_ned_mps": slice(30, 33),
}
_WIDTH = 33
_NOWHERE = (math.nan, math.nan, math.nan)


class RunLog:
    """
    Collects a recording. The data of a tick are kept in one row of numbers and written into the arrays in
    blocks: one assignment for many ticks takes little more time than one for a single tick, and a block is
    small enough for the processor's cache.
    """

    def __init__(self, scenario: Scenario) -> None:
        ids = [vehicle.id for vehicle in scenario.vehicles]
        self._recording = Recording.empty(ids, scenario.tick_times())
        self._actuators = ActuatorLog(ActuatorRows([vehicle.model for vehicle in scenario.vehicles]))
        self._law_rows = [array("d") for _ in ids]
        self._law_sizes = [0] * len(ids)
        self._rows = {name: array(getattr(self._recording, name).dtype.char) for name in _ROWS}
        self._numbers = array("d")
        self._known: list[tuple[int, int, Estimates]] = []
        self._written = 0

    def tick(
        self,
        tick: int,
        states: Sequence[VehicleState],
        navs: Sequence[VehicleState],
        agents: Sequence[Agent],
        commands: Sequence[Command],
        outputs: Sequence[Numbers],
    ) -> None:
        """Note true states, the vehicles' navigation, the agents' decisions and the actuators' outputs."""
        if tick - self._written == _BLOCK_TICKS:
            self._write(tick)
        self._actuators.note(commands, outputs)
        note = self._numbers.extend
        for index, agent in enumerate(agents):
            state, nav, command = states[index], navs[index], self._actuators.command(index, commands[index])
            centre, rate = (agent.centre, agent.centre_rate) if agent.flocks else (_NOWHERE, _NOWHERE)
            note((*state.position, *state.attitude, *state.nu, *nav.position, nav.position_sd_m, *command))
            note((*agent.reference.velocity, cause_number(agent.holding), *centre, *rate))
            if agent.law_state:
                self._law_rows[index].extend((tick, *agent.law_state))
                self._law_sizes[index] = len(agent.law_state)
            if agent.neighbours.addresses:
                self._known.append((tick, index, agent.neighbours))

    def water(
        self,
        tick: int,
        inboxes: Sequence[Inbox],
        handed_over: dict[int, Sequence[Packet]],
        events: Sequence[AcousticEvent],
    ) -> None:
        """Note the transmitted and received packets."""
        rows = self._rows
        for packets in handed_over.values():
            for packet in packets:
                rows["sent"].extend((packet.tick, packet.source, packet.sequence))
        for address, inbox in enumerate(inboxes, start=1):
            for reception in inbox.receptions:
                packet = reception.packet
                rows["received"].extend((tick, packet.source, address, packet.sequence))
                delay_ns = nanoseconds(reception.arrival_s) - nanoseconds(reception.sent_s)
                rows["delay_s"].append(delay_ns * 1e-9)
            for contact in inbox.contacts:
                rows["contacts"].extend((tick, address))
                rows["contact_values"].extend((contact.range_m, contact.bearing_rad, contact.elevation_rad))
        for e in events:
            rows["events"].extend((tick, e.outcome, e.source, e.destination, e.sequence, e.size_bytes))
            times_s = whole_nanoseconds_s(e.start_s), whole_nanoseconds_s(e.end_s)
            rows["event_values"].extend((*times_s, e.snr_db))

    def recording(
        self, n_ticks: int, states: Sequence[VehicleState], outputs: Sequence[Numbers]
    ) -> Recording:
        """
        Return the recording of the first ticks, all that were noted, which end in these true states and with
        these outputs of the actuators.
        """
        r = self._recording
        self._write(n_ticks)
        r.position_ned_m[n_ticks] = [state.position for state in states]
        r.attitude_quat_wxyz[n_ticks] = [state.attitude for state in states]
        r.velocity_body[n_ticks] = [state.nu for state in states]
        shapes = shapes_of(n_ticks + 1, r.n_vehicles)
        arrays = {name: getattr(r, name)[: shape[0]] for name, shape in shapes.items()}
        arrays["law_state"] = self._law_table(n_ticks)
        for name, rows in self._rows.items():
            empty = arrays[name]
            arrays[name] = np.array(rows, empty.dtype).reshape(-1, *empty.shape[1:])
        recording = Recording(vehicle_ids=r.vehicle_ids, **arrays)
        self._actuators.put(recording, outputs)
        return recording

    def _law_table(self, n_ticks: int) -> FloatArray:
        """Return the laws' states in the form of `Recording.law_state`."""
        n_vehicles = self._recording.n_vehicles
        table = np.full((n_ticks, n_vehicles, max(self._law_sizes)), np.nan)
        for index, (numbers, size) in enumerate(zip(self._law_rows, self._law_sizes, strict=True)):
            rows = np.array(numbers).reshape(-1, 1 + size)
            table[rows[:, 0].astype(np.int64), index, :size] = rows[:, 1:]
        return table

    def _write(self, tick: int) -> None:
        """Write the block that ends before `tick` into the arrays."""
        r = self._recording
        block = slice(self._written, tick)
        numbers = np.frombuffer(self._numbers).reshape(-1, r.n_vehicles, _WIDTH)
        for name, columns in _COLUMNS.items():
            getattr(r, name)[block] = numbers[..., columns]
        self._numbers = array("d")
        self._written = tick
        if self._known:
            self._write_known()

    def _write_known(self) -> None:
        """Write the neighbour estimates."""
        r, known = self._recording, [estimates for _, _, estimates in self._known]
        counts = [len(estimates) for estimates in known]
        at, index = (np.repeat([entry[k] for entry in self._known], counts) for k in (0, 1))
        place = (at, index, np.concatenate([estimates.who for estimates in known]) - 1)
        numbers = np.concatenate([estimates.rows for estimates in known])
        r.neighbour_position_ned_m[place] = numbers[:, POSITION:VELOCITY]
        r.neighbour_velocity_ned_mps[place] = numbers[:, VELOCITY:COVARIANCE]
        r.neighbour_covariance[place] = numbers[:, COVARIANCE:AGE].reshape(-1, 6, 6)
        r.neighbour_age_s[place] = numbers[:, AGE]
        r.neighbour_sonar_age_s[place] = numbers[:, SONAR_AGE]
        self._known.clear()
