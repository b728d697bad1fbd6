"""
What one vehicle makes of its inputs: whether it may use its navigation, and where its neighbours are.

The agent takes its inputs in here, and so does the repetition of a recorded run
(`auv_experiment.re_estimate`): which packets and contacts count is said once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from auv_core.messages import Packet, SonarContact, VehicleState
from auv_flocking.input_limits import InputJudge, InputLimits
from auv_flocking.neighbours.estimates import Estimates
from auv_flocking.neighbours.filter import NeighbourConfig, with_rounding
from auv_flocking.neighbours.table import NeighbourTable
from auv_flocking.packet_judge import PacketJudge


class Sensed(NamedTuple):
    """Navigation that may be used, or None and why not; estimates of the neighbours."""

    nav: VehicleState | None
    why_no_nav: str
    neighbours: Estimates


class Senses:
    """
    The inputs of one vehicle, judged, and the filters of its neighbours.

    Attributes
    ----------
    inputs, packets : InputJudge, PacketJudge
        Which navigation, modem and packets count.
    table : NeighbourTable
        The filters.

    """

    def __init__(
        self,
        neighbours: NeighbourConfig,
        limits: InputLimits,
        report_format: Any,
        address: int,
        fleet_size: int,
        period_s: float,
    ) -> None:
        self.inputs = InputJudge(limits, period_s)
        self.packets = PacketJudge(report_format, address, fleet_size, limits)
        self.table = NeighbourTable(with_rounding(neighbours, report_format))

    def take(
        self,
        t_s: float,
        nav: VehicleState | None,
        packets: Sequence[Packet],
        contacts: Sequence[SonarContact],
    ) -> Sensed:
        """
        Return what the inputs of one control period amount to.

        Parameters
        ----------
        t_s : float
            Scenario time (s).
        nav : VehicleState, optional
            The newest navigation, if any came; its tick tells its age.
        packets : sequence of Packet
            What the modem received since the last period, in the order of arrival.
        contacts : sequence of SonarContact
            What the sonar sees.

        """
        if packets:
            for report in self.packets.reports(t_s, packets):
                self.table.receive(report)
        usable, words = self.inputs.navigation(t_s, nav)
        if contacts and usable is not None:
            self.table.observe(t_s, usable, contacts)
        return Sensed(usable, words, self.table.estimates(t_s, usable))
