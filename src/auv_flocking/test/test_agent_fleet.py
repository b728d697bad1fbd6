"""Claims about agents of a fleet in lanes: they fly, and they tell each other where they are in 32 bytes."""

import math
from typing import Any

import pytest
from torpedo_flights import preset

from auv_core import compiled
from auv_core.messages import FinCommand, Inbox, Packet, Reception, VehicleState, command_numbers
from auv_core.models import make_model
from auv_core.params import ConfigError, load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.lanes.status import Mode, apart_m

PERIOD_S, SLOT_S = 0.2, 2.0
RAW = {
    "vehicle_id": "auv_1",
    "address": 1,
    "fleet_size": 2,
    "period_s": PERIOD_S,
    "controller": {"kind": "autopilot"},
    "fleet": {"kind": "lanes", "params": {"cycle_s": 4.0}},
    "report": {"kind": "lane"},
}
STARTS = ((0.0, 20.0, 36.0), (10.0, -40.0, 24.0))


def _agents(**changes):
    return [Agent(load(AgentConfig, {**RAW, "address": address, **changes}, "agent")) for address in (1, 2)]


def _flown(agents, duration_s):
    """Fly two agents in still water, and return the packets that they sent."""
    model = make_model(preset("remus100"))
    states: list[Any] = [model.initial_state(start, 0.0, 1.5) for start in STARTS]
    packets: list[Packet] = []
    on_air: list[Packet] = []
    for tick in range(round(duration_s / PERIOD_S)):
        t_s = tick * PERIOD_S
        turn = round(t_s / SLOT_S) % 2 if tick % round(SLOT_S / PERIOD_S) == 0 else None
        sent = []
        for index, agent in enumerate(agents):
            receptions = tuple(Reception(packet, t_s, t_s, math.nan) for packet in on_air)
            heard = tuple(each for each in receptions if each.packet.source != index + 1)
            nav = VehicleState(tick, states[index][:3], states[index][3:7], states[index][7:13])
            command, given = agent.step(t_s, nav, Inbox(tick, turn == index, heard))
            assert isinstance(command, FinCommand), agent.holding
            sent += given
            states[index] = model.step(
                states[index], model.limited_command(command_numbers(command)), (0.0, 0.0, 0.0), 0.1, 2
            )
        on_air = sent
        packets += sent
    return packets


def test_two_agents_come_into_formation(monkeypatch):
    monkeypatch.setattr(compiled, "_is_on", True)
    agents = _agents()
    packets = _flown(agents, 240.0)
    assert {len(packet.payload) for packet in packets} == {32}
    assert all(agent.rejected == agent.saturated == agent.unsent == 0 for agent in agents)
    assert [agent.task.mode.mode for agent in agents] == [Mode.FORM, Mode.FORM]
    first, second = (agent.task.gamma_m for agent in agents)
    assert abs(apart_m(first, second, agents[0].task.round_m)) < 1.0
    assert len(packets) < 0.7 * 240.0 / SLOT_S, "in formation most slots stay empty"


def test_without_navigation_a_vehicle_circles():
    (agent, _) = _agents()
    command, packets = agent.step(0.0, None, Inbox(0, True, ()))
    assert command == agent.task.safe_command == FinCommand(math.radians(15.0), 0.0, 600.0)
    assert packets == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"course": {"kind": "steps"}}, r"course: 'steps' is not allowed; allowed: nothing beside a fleet"),
        ({"controller": {"kind": "pfpd"}, "reference": {"kind": "circle"}}, r"fleet: 'lanes' is not allowed"),
        ({"fleet": None}, r"course: missing; allowed: a section"),
        ({"fleet": {"kind": "swarm"}}, r"agent.fleet.kind: 'swarm' is not allowed; allowed: lanes"),
    ],
)
def test_parts_that_do_not_fit_are_refused(changes, words):
    with pytest.raises(ConfigError, match=words):
        load(AgentConfig, {**RAW, **changes}, "agent")
