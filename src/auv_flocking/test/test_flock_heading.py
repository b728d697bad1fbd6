"""Claims about the heading of a flock: only a leader has that of the path, others take it from packets."""

import math

import numpy as np
import pytest

from auv_core.geometry import quaternion_from_heading
from auv_core.messages import Inbox, Packet, Reception, VehicleState
from auv_core.params import load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.neighbours.estimates import Estimates, NeighbourEstimate, heading_nearest_leader_rad
from auv_flocking.report import NEVER, Report
from auv_flocking.reports import exact

PERIOD_S, OWN_RAD = 0.1, 0.3
FORMAT = exact.Format(exact.Params(), ())
ZERO = (0.0, 0.0, 0.0)


def agent_of(path_heading_rad, *, is_leader=False, controller="velocity_pi"):
    circle = {"kind": "circle", "params": {"heading_rad": path_heading_rad}}
    raw = {
        "vehicle_id": "auv_2",
        "address": 2,
        "fleet_size": 3,
        "is_leader": is_leader,
        "period_s": PERIOD_S,
        "reference": circle,
        "flocking": {"kind": "communication_aware"},
        "separation": {"kind": "mathematical"},
        "consensus": {"kind": "neighbour_mean"},
        "report": {"kind": "exact"},
        "controller": {"kind": controller},
    }
    return Agent(load(AgentConfig, raw, "agent"))


def packet_of(tick, address, heading_rad, stamp_s):
    time_s = (tick - 1) * PERIOD_S
    place = (3.0 + address, 9.0, 10.0)
    report = Report(address, time_s, place, ZERO, place, ZERO, stamp_s, heading_rad=heading_rad)
    return Reception(Packet(tick - 1, address, 0, tick, FORMAT.encode(report)), 0.0, 0.0, math.nan)


def stepped(agent, tick, *receptions):
    nav = VehicleState(tick, (1.0, 9.0, 10.0), quaternion_from_heading(OWN_RAD), (0.0,) * 6)
    return agent.step(tick * PERIOD_S, nav, Inbox(tick, False, receptions))


@pytest.mark.parametrize("controller", ["velocity_pi", "velocity_direct"])
def test_a_follower_that_hears_nothing_does_not_know_the_heading_of_the_path(controller):
    flights = []
    for path_heading_rad in (0.0, 2.0):
        agent = agent_of(path_heading_rad, controller=controller)
        flights.append([repr(stepped(agent, tick)) for tick in range(20)])
        assert agent.reference.heading_rad == pytest.approx(OWN_RAD)
    assert flights[0] == flights[1]


def test_a_leader_has_the_heading_of_the_path():
    agent = agent_of(2.0, is_leader=True)
    stepped(agent, 0)
    assert agent.reference.heading_rad == 2.0


def test_a_follower_takes_the_heading_of_the_leader_that_it_hears_and_keeps_it():
    agent = agent_of(2.0)
    stepped(agent, 0)
    stepped(agent, 1, packet_of(1, 3, -1.0, NEVER))
    assert agent.reference.heading_rad == pytest.approx(OWN_RAD)
    stepped(agent, 2, packet_of(2, 1, 1.2, 0.1))
    assert agent.reference.heading_rad == pytest.approx(1.2)
    for tick in range(3, 30):
        stepped(agent, tick)
    assert agent.reference.heading_rad == pytest.approx(1.2)


def estimate(address, heading_rad, stamp_s, time_s):
    return NeighbourEstimate(
        address, ZERO, ZERO, np.eye(6), 0.0, ZERO, ZERO, stamp_s, time_s=time_s, heading_rad=heading_rad
    )


def test_the_heading_is_that_of_the_neighbour_nearest_to_a_leader():
    relay, leader = estimate(2, 0.5, 8.0, 9.5), estimate(3, 1.0, 8.0, 8.0)
    older, silent = estimate(4, 1.5, 7.0, 9.0), estimate(5, math.nan, 9.0, 9.0)
    unled = estimate(6, 2.0, NEVER, 9.0)
    rows = Estimates.of([relay, leader, older, silent, unled]).rows
    assert heading_nearest_leader_rad(rows) == 1.0
    assert heading_nearest_leader_rad(rows[[0, 2, 3, 4]]) == 0.5
    assert math.isnan(heading_nearest_leader_rad(rows[3:]))
    assert math.isnan(heading_nearest_leader_rad(rows[:0]))
