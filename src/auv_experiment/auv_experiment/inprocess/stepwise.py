"""A sampled run in one process that is flown tick by tick, in the order of the nodes."""

from __future__ import annotations

from collections.abc import Sequence

from auv_core.messages import AcousticEvent, Command, Inbox, Numbers, Packet
from auv_experiment.compose import agent_configs, vehicle_configs
from auv_experiment.inprocess.run_log import RunLog
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent
from auv_sim.acoustics.medium import AcousticMedium
from auv_sim.vehicle import Vehicle


class StepwiseRun:
    """
    A run at a tick. `decide` lets the agents read their inboxes and give commands; `act` carries them out.

    Attributes
    ----------
    tick : int
        Number of completed control periods.
    vehicles, agents
        In the order of addresses.
    states, navs : list of VehicleState
        True states at the tick, and the vehicles' navigation.
    inboxes : sequence of Inbox
        Data from modems and sonars at the tick of the last decision.

    """

    def __init__(self, scenario: Scenario) -> None:
        self.vehicles = [Vehicle(config) for config in vehicle_configs(scenario)]
        self.agents = [Agent(config) for config in agent_configs(scenario)]
        self.tick = 0
        self.states = [vehicle.state for vehicle in self.vehicles]
        self.navs = [vehicle.nav for vehicle in self.vehicles]
        self.inboxes: Sequence[Inbox] = ()
        self._medium = AcousticMedium(scenario.medium_config, scenario.environment.obstacles)
        self._period_s = scenario.period_s
        self._log = RunLog(scenario)
        self._handed_over: dict[int, Sequence[Packet]] = {}
        self._events: Sequence[AcousticEvent] = ()

    def decide(self) -> list[Command]:
        """Let every agent read its inbox; return their commands. Call it once per tick."""
        self.inboxes = self._medium.exchange(self.tick, self.states)
        commands: list[Command] = []
        self._handed_over = {}
        for index, agent in enumerate(self.agents):
            command, packets = agent.step(self.tick * self._period_s, self.navs[index], self.inboxes[index])
            commands.append(command)
            self._handed_over[index + 1] = packets
        self._medium.transmit(self._handed_over, self.states)
        self._events = self._medium.take_events()
        return commands

    def act(self, commands: Sequence[Command]) -> None:
        """
        Advance the vehicles by one control period with these commands.

        Raises
        ------
        DivergedError
            If a motion has no finite solution.

        """
        self._log.tick(self.tick, self.states, self.navs, self.agents, commands, self._outputs())
        self._log.water(self.tick, self.inboxes, self._handed_over, self._events)
        self.states = [
            vehicle.step(command) for vehicle, command in zip(self.vehicles, commands, strict=True)
        ]
        self.navs = [vehicle.nav for vehicle in self.vehicles]
        self.tick += 1

    def recording(self) -> Recording:
        """Return the recording of the ticks that are behind us."""
        return self._log.recording(self.tick, self.states, self._outputs())

    def _outputs(self) -> list[Numbers]:
        """Return the outputs of every vehicle's actuators at the tick."""
        return [vehicle.actuator_outputs for vehicle in self.vehicles]
