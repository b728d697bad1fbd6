"""What an agent says of itself names who is not heard, why and since when."""

import math

import pytest

pytest.importorskip("rclpy")

from auv_core.messages import Inbox, Packet, Reception, VehicleState
from auv_core.params import load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.mail import Mail
from auv_flocking.nodes.agent_diagnostics import agent_statuses
from auv_flocking.report import Report
from auv_flocking.reports import exact

pytestmark = pytest.mark.ros

OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"
FORMAT = exact.Format(exact.Params(), ())
CONFIG = load(
    AgentConfig,
    {
        "vehicle_id": "auv_1",
        "address": 1,
        "fleet_size": 3,
        "fleet_ids": ["auv_1", "otter", "auv_3"],
        "reference": {"kind": "circle"},
        "flocking": {"kind": "potential"},
        "separation": {"kind": "mathematical"},
        "consensus": {"kind": "thesis", "params": {"carried_by": "flock"}},
        "report": {"kind": "exact"},
        "controller": {"kind": "velocity_direct"},
    },
    "agent",
)


def packet(address, tag_s):
    zero = (0.0, 0.0, 0.0)
    report = Report(address, tag_s, (5.0, 9.0, 10.0), zero, zero, zero)
    return Reception(Packet(0, address, 0, 1, FORMAT.encode(report)), 0.0, 0.0, math.nan)


def step(agent, tick, *receptions, nav_tick=None):
    nav_tick = tick if nav_tick is None else nav_tick
    nav = VehicleState(nav_tick, (0.0, 9.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)
    agent.step(0.1 * tick, nav, Inbox(tick, False, receptions))


def said(agent, mail, t_s):
    """Return level and message of the three statuses: neighbours, control law, inputs."""
    return [(each.level, each.message) for each in agent_statuses(agent, CONFIG, mail, 0, t_s)]


def test_clocks_that_differ_are_named_and_so_is_who_says_nothing():
    agent, mail = Agent(CONFIG), Mail(CONFIG.inputs, CONFIG.period_s)
    for tick in range(11):
        step(agent, tick, packet(2, 0.1 * tick + 2.1))
    neighbours, law, inputs = said(agent, mail, 1.0)
    assert neighbours == (
        WARN,
        "otter: time tag 2.1 s in the future, allowed: 1 s, for 1.0 s, 11 packets; 2 not heard: otter, auv_3",
    )
    assert (law, inputs) == ((OK, "acts"), (OK, "0 left out"))
    step(agent, 11, packet(2, 1.0), packet(3, 1.0))
    assert said(agent, mail, 1.1)[0] == (OK, "oldest packet 0.1 s")


def test_a_hold_is_an_error_with_its_age_and_dropped_inputs_are_named():
    agent, mail = Agent(CONFIG), Mail(CONFIG.inputs, CONFIG.period_s)
    step(agent, 0)
    mail.navs.hear(VehicleState(10**9, (0.0,) * 3, (1.0, 0.0, 0.0, 0.0), (0.0,) * 6), 10**9, 8)
    step(agent, 8, nav_tick=0)
    _, law, inputs = said(agent, mail, 0.8)
    assert law == (ERROR, "safe command: stale navigation: 0.8 s old, allowed: 0.5 s")
    assert inputs[0] == WARN
    assert inputs[1].startswith(
        "left out, last: navigation of tick 1000000000 at tick 8: 99999999.2 s in the"
    )
