"""
Inputs of one vehicle: checks its navigation and updates its neighbour estimates.

The agent and the repetition of a recorded run (`auv_experiment.re_estimate`) both use it, so that the rule
for accepted packets and contacts exists once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from auv_core.messages import Packet, SonarContact, VehicleState
from auv_flocking.agent_config import AgentConfig, report_decoder
from auv_flocking.input_limits import InputJudge, InputLimits
from auv_flocking.neighbours.estimates import Estimates
from auv_flocking.neighbours.filter import NeighbourConfig, with_rounding
from auv_flocking.neighbours.table import NeighbourTable
from auv_flocking.packet_judge import PacketJudge
from auv_flocking.pings import Echo, Ping, echoes_of
from auv_flocking.reports import ReportDecoder
from auv_flocking.trackers import ObstacleTracker, Sensed, make_tracker


class Perceived(NamedTuple):
    """Usable navigation, or None and why not; neighbour estimates; sensed obstacles; the newest ping."""

    nav: VehicleState | None
    why_no_nav: str
    neighbours: Estimates
    obstacles: Sensed
    ping: Ping


class Senses:
    """
    Checks the inputs of one vehicle and keeps the filters of its neighbours.

    Attributes
    ----------
    inputs, packets : InputJudge, PacketJudge
        Decide which navigation, modem data and packets are accepted.
    table : NeighbourTable
        The filters.
    obstacles : ObstacleTracker
        What contacts of no neighbour are.

    """

    def __init__(
        self,
        neighbours: NeighbourConfig,
        limits: InputLimits,
        decoder: ReportDecoder,
        address: int,
        fleet_size: int,
        period_s: float,
        obstacles: ObstacleTracker,
        *,
        has_sonar: bool = True,
    ) -> None:
        self.inputs = InputJudge(limits, period_s)
        self.packets = PacketJudge(decoder, address, fleet_size, limits)
        self.table = NeighbourTable(with_rounding(neighbours, decoder), has_sonar=has_sonar)
        self.obstacles = obstacles
        self._fleet_size = fleet_size
        self._has_sonar = has_sonar
        self._echoes: tuple[Echo, ...] = ()
        self._ping_s = -math.inf

    def take(
        self,
        t_s: float,
        nav: VehicleState | None,
        packets: Sequence[Packet],
        contacts: Sequence[SonarContact],
    ) -> Perceived:
        """
        Return the result of the inputs of one control period.

        Parameters
        ----------
        t_s : float
            Scenario time (s).
        nav : VehicleState, optional
            The newest navigation, if any; its tick gives its age.
        packets : sequence of Packet
            Packets that the modem received since the last period, in the order of arrival.
        contacts : sequence of SonarContact
            Sonar contacts.

        """
        if packets:
            for report in self.packets.reports(t_s, packets):
                self.table.receive(report)
        usable, words = self.inputs.navigation(t_s, nav)
        if usable is not None:
            fix = self.table.follow(t_s, usable)
            if fix is not None:
                self.obstacles.follow(fix)
        if contacts and usable is not None:
            left = self.table.observe(
                t_s,
                usable,
                contacts,
                self.obstacles.rivals(t_s),
                has_unheard=self.table.heard < self._fleet_size - 1,
            )
            self.obstacles.observe(t_s, left)
            if self._has_sonar:
                self._echoes, self._ping_s = echoes_of(usable, contacts), t_s
        ping = Ping(self._echoes, t_s - self._ping_s)
        return Perceived(usable, words, self.table.estimates(t_s), self.obstacles.obstacles(t_s), ping)


def senses_of(config: AgentConfig) -> Senses:
    """Return the senses of one agent, before its first inputs."""
    return Senses(
        config.neighbours,
        config.inputs,
        report_decoder(config),
        config.address,
        config.fleet_size,
        config.period_s,
        make_tracker(config.obstacle_tracker, tuple(position for position, _ in config.obstacles)),
        has_sonar=config.has_sonar,
    )
