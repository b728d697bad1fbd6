"""A run that is flown step by step, with optional commands from the caller."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from auv_core.compiled import use_compiler
from auv_core.messages import Command, Inbox, VehicleState, VelocityCommand, command_numbers, command_of
from auv_core.params import ConfigError, shown
from auv_experiment.inprocess.stepwise import StepwiseRun
from auv_experiment.run_memory import check_memory
from auv_experiment.scenario import schema
from auv_sim.vehicle import DivergedError, Vehicle
from shoal.plain import plain
from shoal.result import Result
from shoal.scenario import Scenario, load, resolve


class Simulation:
    """
    A flock between two ticks: inspect it, replace commands, step.

    A scenario in continuous time is flown sampled, as by the nodes. A simulation that is flown to its end
    without replaced commands equals the result of `run` to the last bit. To look ahead, step a
    ``copy.deepcopy`` of it.

    Parameters
    ----------
    scenario : Scenario, str or Path
        What to fly, as for `run`.
    seed : int, optional
        Seed of every random number; by default the scenario's.
    duration_s : float, optional
        Length of the flight (s); by default the scenario's.

    Examples
    --------
    >>> import shoal
    >>> simulation = shoal.Simulation("flock_acoustic", seed=3)
    >>> while simulation.time_s < 1.0:
    ...     thrust = simulation.commands["auv_1"].tau
    ...     simulation.step({"auv_1": [0.5 * each for each in thrust]})
    >>> round(simulation.states["auv_1"].position[2])
    15

    """

    def __init__(
        self,
        scenario: Scenario | schema.Scenario | str | Path,
        *,
        seed: int | None = None,
        duration_s: float | None = None,
    ) -> None:
        self._scenario = load(scenario) if isinstance(scenario, str | Path) else scenario
        self._duration_s = duration_s
        use_compiler()
        self.reset(seed)

    def __repr__(self) -> str:
        run = self.scenario
        return f"<shoal.Simulation {run.name}, seed {run.seed}, at {self.time_s:g} s of {run.duration_s:g} s>"

    def reset(self, seed: int | None = None) -> None:
        """
        Restart at time 0.

        Parameters
        ----------
        seed : int, optional
            Seed of the new run; by default the scenario's.

        """
        resolved = resolve(self._scenario, seed=seed, duration_s=self._duration_s)
        self.scenario: schema.Scenario = replace(resolved, sampling="sampled")
        check_memory(self.scenario)
        self.vehicle_ids = tuple(vehicle.id for vehicle in self.scenario.vehicles)
        self._run = StepwiseRun(self.scenario)
        self._decided: list[Command] | None = None
        self._has_diverged = False

    @property
    def time_s(self) -> float:
        """Scenario time (s)."""
        return self._run.tick * self.scenario.period_s

    @property
    def is_done(self) -> bool:
        """Whether the run has reached its end."""
        return self._run.tick >= self.scenario.ticks

    @property
    def states(self) -> dict[str, VehicleState]:
        """True state of every vehicle by name: position (m; NED), attitude, nu (m/s, rad/s; FRD)."""
        return dict(zip(self.vehicle_ids, self._run.states, strict=True))

    @property
    def estimates(self) -> dict[str, VehicleState]:
        """State of every vehicle from its own navigation, by name."""
        return dict(zip(self.vehicle_ids, self._run.navs, strict=True))

    @property
    def inboxes(self) -> dict[str, Inbox]:
        """Data from modem and sonar of every vehicle at this tick, by name."""
        self._decisions()
        return dict(zip(self.vehicle_ids, self._run.inboxes, strict=True))

    @property
    def commands(self) -> dict[str, Command]:
        """Command of every vehicle's own software at this tick, by name."""
        return dict(zip(self.vehicle_ids, self._decisions(), strict=True))

    def step(self, commands: Mapping[str, Command | Sequence[float]] | None = None) -> None:
        """
        Fly one control period.

        Parameters
        ----------
        commands : mapping, optional
            Commands that replace those of the vehicles' own software, by name: six numbers [X, Y, Z, K, M,
            N] (N, N m; body FRD), for a kinematic vehicle four numbers, velocity (m/s; NED) and yaw rate
            (rad/s), for a torpedo three, rudder and stern plane (rad) and propeller (rpm), and for thrusters
            one force each (N). Actuator limits apply as for any command.

        Raises
        ------
        ConfigError
            If a vehicle does not exist, or the numbers are no command; then nothing is flown.
        DivergedError
            If a motion has no finite solution; only `reset` is possible afterwards.
        RuntimeError
            At the end of the run.

        """
        decided = list(self._decisions())
        if not isinstance(commands, Mapping | None):
            raise ConfigError(f"commands: {shown(commands)} is not allowed; allowed: a mapping by vehicle")
        for name, given in (commands or {}).items():
            if name not in self.vehicle_ids:
                raise ConfigError(
                    f"commands: {shown(name)} is not allowed; allowed: {', '.join(self.vehicle_ids)}"
                )
            index = self.vehicle_ids.index(name)
            decided[index] = _command(name, given, self._run.vehicles[index])
        try:
            self._run.act(decided)
        except DivergedError:
            self._has_diverged = True
            raise
        self._decided = None

    def result(self) -> Result:
        """
        Return the result so far, as of a run that was stopped here.

        Further steps are possible.

        Raises
        ------
        RuntimeError
            Before the first step.

        """
        if self._run.tick == 0:
            raise RuntimeError("no step has been flown yet; call step first")
        return Result(self.scenario, self._run.recording(), mode="inprocess")

    def _decisions(self) -> list[Command]:
        if self._has_diverged:
            raise RuntimeError("a motion has no finite solution; call reset to restart")
        if self._decided is None:
            if self.is_done:
                raise RuntimeError(f"the run has reached its end at {self.time_s:g} s; call reset to restart")
            self._decided = self._run.decide()
        return self._decided


def _command(name: str, given: Command | Sequence[float], vehicle: Vehicle) -> Command:
    """Return the numbers for a vehicle as its kind of command."""
    takes_velocity = vehicle.command == "velocity"
    numbers: Any = plain(given)
    if isinstance(given, VelocityCommand):
        numbers = (*given.velocity, given.yaw_rate_radps)
    elif isinstance(given, Command):
        numbers = command_numbers(given)
    length = 4 if takes_velocity else vehicle.command_size
    are_numbers = isinstance(numbers, list | tuple) and all(isinstance(each, int | float) for each in numbers)
    if not are_numbers or len(numbers) != length or not all(map(math.isfinite, numbers)):
        raise ConfigError(f"commands.{name}: {shown(given)} is not allowed; allowed: {length} finite numbers")
    values = [float(each) for each in numbers]
    if takes_velocity:
        return VelocityCommand((values[0], values[1], values[2]), values[3])
    return command_of(vehicle.command, tuple(values))
