"""
Supervision of a flight: which vehicles are lost, whether to continue, when it is over.

Its inputs are the launcher's observations (ended processes, status messages of the clock, elapsed time). It
decides, and keeps messages for the user. It starts and ends no process and does not use ROS, so every case is
tested without a process.

The rules: losing a vehicle (a process of its vehicle_node or agent_node) stops the flight or takes that
vehicle out of it, as the scenario says; losing relay, clock or recorder always stops it, and so does losing
the process that holds all nodes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from auv_bringup.launching.end_claims import EXIT_STATUS, EndClaims
from auv_bringup.launching.flight_status import LOST_STATUS, Status, start_of_run
from auv_bringup.launching.layout import ProcessSpec, patience_s, start_patience_s, vehicles_of
from auv_bringup.launching.standing_claims import StandingClaims
from auv_core.machine.child_end import Exit
from auv_ros.run_identity import follows, is_of_run

NO_STATUS_S = 60.0
"""Longest wait for the first status of the clock."""
SILENCE_S = 4.0
"""The clock sends about five statuses a second; without one for this long it has stopped answering."""
STALL_S = 4.5
"""Longest stall that is tolerated; the clock notices it and acts much earlier."""
RELAY_EXIT_GRACE_S = 1.0
"""The last status of a relay may arrive after its end was noticed."""
STOPPED_S = 2.0
"""A process that a signal (SIGSTOP) has stopped for this long is lost, even during the start."""
SLOW_START_S = 15.0
"""After this time the user gets the names of the nodes that the start waits for."""

CLAIM_S = 1.5
"""Time for which the clock must repeat a loss, or a stall that ends the flight, before it counts."""
LEAVE_S = 10.0
"""Within this time after the run the process of the clock delivers its messages and ends."""
LEAVE_RECORDING_S = 30.0
"""The same for a process that has a bag to close, too."""


class Supervisor:
    """
    Supervises one flight.

    Attributes
    ----------
    status : Status, optional
        The last one that arrived.
    is_over : bool
        Whether to end the nodes now.
    exit_status : int
        0, or 3 when the flight was stopped because of a loss.
    reason : str
        Why it was stopped, one line; '' if it was not.
    lost_vehicles : list of str
        Vehicles that the flight went on without, in the order of loss.
    stopped_processes : list of str
        Names of the processes lost because a signal has stopped them.

    """

    def __init__(self, processes: Sequence[ProcessSpec], *, on_vehicle_loss: str) -> None:
        self._processes = {process.name: process for process in processes}
        self._vehicle_ids = {process.vehicle_id for process in processes}
        self._process_of = {node.name: process for process in processes for node in process.nodes}
        self._patience_s = patience_s(vehicles_of(processes))
        self._start_patience_s = start_patience_s(vehicles_of(processes))
        self._goes_on = on_vehicle_loss == "continue"
        self._stopwatch = _Stopwatch()
        self._messages: list[str] = []
        self._to_end: list[str] = []
        self._losses = StandingClaims(CLAIM_S + self._patience_s)
        self._vital_stalls = StandingClaims(CLAIM_S + self._patience_s)
        self._stalls = StandingClaims(STALL_S + self._patience_s)
        self._why_lost: dict[str, str] = {}
        self._named_stalled: set[str] = set()
        self._silent_s = 0.0
        self._run = start_of_run(processes)
        records_too = any(process.role == "relay" and process.records for process in processes)
        self._ends = EndClaims(self._start_patience_s + (LEAVE_RECORDING_S if records_too else LEAVE_S))
        self._disbelieved: set[str] = set()
        self._relay_exit: tuple[Exit, Sequence[str], str] | None = None
        self._relay_gone_s = 0.0
        self._stopped_for_s: dict[str, float] = {}
        self._waiting_s = 0.0
        self._doubts = False
        self.status: Status | None = None
        self.is_over = False
        self.exit_status = 0
        self.reason = ""
        self.lost_vehicles: list[str] = []
        self.stopped_processes: list[str] = []

    @property
    def has_begun(self) -> bool:
        """Whether the first tick has been announced."""
        return self.status is not None and self.status.state != "waiting"

    @property
    def is_finished(self) -> bool:
        """Whether the flight came to its planned end."""
        return self.status is not None and self.status.state == "finished"

    @property
    def simulated_s(self) -> float:
        """Scenario time reached (s)."""
        return self.status.time_s if self.status is not None else 0.0

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second of wall time, of the flight only; NaN if it was too short to tell."""
        return self._stopwatch.factor

    def take_messages(self) -> list[str]:
        """Return the lines for the user since the last call."""
        messages, self._messages = self._messages, []
        return messages

    def take_processes_to_end(self) -> list[str]:
        """Return the names of the processes to end since the last call: those of vehicles just lost."""
        names, self._to_end = self._to_end, []
        return names

    def status_arrived(self, status: Status, wall_s: float) -> None:
        """
        Take a status of the clock, received at `wall_s` on any steady clock (s).

        A status of another run, or one that goes back in time, comes from another clock and is ignored. An
        end counts once the process of the clock has ended accordingly, a lost vehicle once the clock has
        repeated it for `CLAIM_S`.
        """
        if not self._is_next(status):
            self._doubt(status)
            return
        self._silent_s = 0.0
        if status.state in EXIT_STATUS:
            self._ends.add(status, wall_s)
            if self._relay_exit is not None:
                self._confirm_end(self._relay_exit[0])
            return
        self.status = status
        if status.state != "waiting":
            self._run = status.point
            self._contradict_end()
        if status.state == "running":
            self._stopwatch.lap(status.time_s, wall_s)
        self._claim_losses(status)
        self._stall(status.waiting_for if status.state == "stalled" else (), status.time_s)

    def _is_next(self, status: Status) -> bool:
        """Return whether the status is plausible for the clock of this run."""
        if status.state == "waiting":
            return self._run.state == "waiting" and status.duration_s == self._run.duration_s
        return follows(self._run, status.point)

    def _doubt(self, status: Status) -> None:
        if is_of_run(self._run, status.point):
            self._silent_s = 0.0  # it may be the clock, and the known state a foreign one
        if not self._doubts:
            self._doubts = True
            self._messages.append(
                f"/flock/status says {status.state} at {status.time_s:g} of {status.duration_s:g} s "
                f"(this run: {self._run.time_s:g} of {self._run.duration_s:g} s): "
                "another run publishes it; ignored"
            )

    def _contradict_end(self) -> None:
        """Report once that an end was claimed although the run goes on."""
        if self._ends.are_open:
            end = self._ends.contradict()
            self._disbelieve("end", f"{end.state} at {end.time_s:g} s, but the run's own process goes on")

    def _losses_in(self, status: Status) -> list[str]:
        """Return the vehicles that a status gives up; a clock gives up none if a loss ends the flight."""
        return [name for name in status.lost_vehicles if self._goes_on and name in self._vehicle_ids]

    def _claim_losses(self, status: Status) -> None:
        claimed = [name for name in self._losses_in(status) if name not in self.lost_vehicles]
        self._why_lost = {name: self._why_lost.get(name) or _why_lost(name, status) for name in claimed}
        for name in self._losses.hear(claimed):
            if name not in self.lost_vehicles:
                self._disbelieve(name, f"{name} is lost, but the run's own clock goes on with it")

    def _disbelieve(self, what: str, words: str) -> None:
        if what not in self._disbelieved:
            self._disbelieved.add(what)
            self._messages.append(f"/flock/status says {words}: a foreign process publishes it; ignored")

    def _confirm_end(self, exit_: Exit) -> bool:
        """Accept the claimed end that fits the end of the clock's process, if there is one."""
        end = self._ends.confirmed_by(exit_.returncode)
        if end is None:
            return False
        self.status, wall_s = end
        for name in self._losses_in(self.status):
            self._lose_vehicle(name, _why_lost(name, self.status))
        if self.is_finished:
            self._stopwatch.lap(self.status.time_s, wall_s)
            self.is_over = True
        else:
            awaited = _listed(self.status.waiting_for)
            self._stop(self.status.detail or f"the clock ended the run; it waited for {awaited}")
        return True

    def process_ended(self, exit_: Exit, log_lines: Sequence[str], log: str) -> None:
        """Take the end of a process, with the last lines and the path of its log."""
        process = self._processes[exit_.name]
        is_usual_at_end = exit_.returncode == 0 and (self.is_finished or self._ends.are_open)
        if process.vehicle_id in self.lost_vehicles or (is_usual_at_end and process.role != "relay"):
            return
        if process.role == "relay" and exit_.returncode in EXIT_STATUS.values() and self._relay_exit is None:
            if not self._confirm_end(exit_):
                self._relay_exit = exit_, log_lines, log
            return
        self._ended_early(exit_, log_lines, log)

    def _ended_early(self, exit_: Exit, log_lines: Sequence[str], log: str) -> None:
        process = self._processes[exit_.name]
        self._messages.append(f"{exit_.name} has ended early: {exit_.words}; its log is {log}")
        self._messages += [f"    {line}" for line in log_lines]
        why = f"{exit_.name} has ended early ({exit_.words})"
        if len(process.nodes) > 1 and log_lines:
            why += f": {log_lines[-1]}"  # it names the node
        self._lose(process, why)

    def processes_stopped(self, stopped: Mapping[str, str], awake_s: float) -> None:
        """
        Note the processes that are stopped by a signal, or have started a stopped one, for another `awake_s`
        (s).

        `stopped` has, by name, the stopped process that they have started, '' for themselves.
        """
        before_s = self._stopped_for_s
        self._stopped_for_s = {name: before_s.get(name, 0.0) + awake_s for name in stopped}
        for name, started in stopped.items():
            if before_s.get(name, 0.0) <= STOPPED_S < self._stopped_for_s[name]:
                process = self._processes[name]
                if not started:
                    self.stopped_processes.append(name)
                also = " (with /clock_node)" if process.role == "relay" else ""
                who = f"{started}, started by {name}," if started else f"{name}{also}"
                self._lose(process, f"{who} is stopped by a signal")

    def time_passed(self, awake_s: float) -> None:
        """Let `awake_s` of wall time pass in which a status could have been received (s)."""
        if self.is_over:
            return
        self._silent_s += awake_s
        end_is_late = self._ends.time_passed(awake_s)
        for name in self._losses.time_passed(awake_s):
            self._lose_vehicle(name, self._why_lost[name])
        stalled = [*self._vital_stalls.time_passed(awake_s), *self._stalls.time_passed(awake_s)]
        if stalled:
            self._stop(f"{_listed(stalled)} stopped answering")
        if self._relay_exit is not None:
            self._relay_gone_s += awake_s
            if self._relay_gone_s > RELAY_EXIT_GRACE_S:
                self._ended_early(*self._relay_exit)
        elif self._ends.are_open:
            if end_is_late:
                self._contradict_end()
        elif self.status is None:
            limit_s = NO_STATUS_S + self._start_patience_s
            if self._silent_s > limit_s:
                self._stop(
                    f"no status from /clock_node within {limit_s:g} s: "
                    "the nodes do not find each other, or do not start "
                    "(their logs say more)"
                )
        elif self._silent_s > SILENCE_S + self._patience_s:
            self._stop(
                "/clock_node (process of /acoustic_relay_node) has not answered for "
                f"{SILENCE_S + self._patience_s:.3g} s"
            )
        self._mention_slow_start(awake_s)

    def _mention_slow_start(self, awake_s: float) -> None:
        if self.status is None or self.status.state != "waiting":
            return
        before_s, self._waiting_s = self._waiting_s, self._waiting_s + awake_s
        if before_s <= SLOW_START_S < self._waiting_s:
            self._messages.append(f"still waiting for {_listed(self.status.waiting_for)}")

    def _stall(self, names: Sequence[str], time_s: float) -> None:
        self._stalls.hear(names)
        self._vital_stalls.hear([name for name in names if self._is_vital(name)])
        for name in names:
            if name not in self._named_stalled:
                self._named_stalled.add(name)
                self._messages.append(f"{name} does not answer (at {time_s:.1f} s of the flight)")

    def _is_vital(self, name: str) -> bool:
        process = self._process_of.get(name)
        return process is None or not process.vehicle_id

    def _lose(self, process: ProcessSpec, why: str) -> None:
        if process.vehicle_id and self._goes_on:
            self._lose_vehicle(process.vehicle_id, why)
        else:
            self._stop(why)

    def _lose_vehicle(self, vehicle_id: str, why: str) -> None:
        if vehicle_id in self.lost_vehicles:
            return
        self.lost_vehicles.append(vehicle_id)
        self._to_end += [
            name for name, process in self._processes.items() if process.vehicle_id == vehicle_id
        ]
        self._messages.append(
            f"{why}: {vehicle_id} is lost at {self.simulated_s:.1f} s; the flight goes on without it"
        )

    def _stop(self, reason: str) -> None:
        if not self.is_over:
            self.is_over = True
            self.exit_status = LOST_STATUS
            self.reason = reason


class _Stopwatch:
    """Scenario time against wall time, from the last lap before progress to the last lap with progress."""

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None
        self._last: tuple[float, float] | None = None

    def lap(self, time_s: float, wall_s: float) -> None:
        if self._first is None or time_s <= self._first[0]:
            self._first = (time_s, wall_s)
        if self._last is None or time_s > self._last[0]:
            self._last = (time_s, wall_s)

    @property
    def factor(self) -> float:
        if self._first is None or self._last is None or self._last[1] <= self._first[1]:
            return math.nan
        return (self._last[0] - self._first[0]) / (self._last[1] - self._first[1])


def _why_lost(vehicle_id: str, status: Status) -> str:
    return status.detail or f"{vehicle_id} does not answer"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "connections between nodes that have all started"
