"""Modems that are silent in real time because the positions of their vehicles are not known."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

from auv_core.alarm import Alarm
from auv_core.words import listed
from auv_ros.run_config import TickClock
from auv_sim.nodes.link_reports import LinkReports
from auv_sim.nodes.water_topics import STATS_TICKS
from auv_sim.relay.state_watch import StateWatch


class StateReport:
    """
    Logs and publishes, for the relay, which states are too old.

    Parameters
    ----------
    logger : rclpy logger
        Of the relay.
    reports : LinkReports
        Publishes the findings.
    states : StateWatch
        The states.
    ticks : TickClock
        The time of the run.

    """

    def __init__(self, logger: Any, reports: LinkReports, states: StateWatch, ticks: TickClock) -> None:
        self._alarm = Alarm(logger, "modems silent", "modems speak again")
        self._reports = reports
        self._states = states
        self._ticks = ticks

    def tell(self, tick: int, *, without: Container[int]) -> None:
        """Report the states at a tick, without those of some vehicles, if a report is due."""
        reasons = {
            vehicle: words
            for vehicle in self._states.vehicles
            if vehicle not in without and (words := self._states.why_stale(vehicle, tick))
        }
        words = listed(list(reasons.values()))
        is_new = self._alarm.note(tuple(reasons), words, self._ticks.scenario_s(tick))
        if is_new or tick % STATS_TICKS == 0:
            self._reports.tell_states(words, self._states, self._ticks.stamp_s(tick))
