"""Claims about the agent of a vehicle with fins: course, autopilots, safe command, failure."""

import math

import pytest
from torpedo_flights import STILL, remus

from auv_core.geometry import quaternion_from_heading
from auv_core.messages import FinCommand, Inbox, VehicleState
from auv_core.params import ConfigError, load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.course_task import CROSS_TRACK, DEPTH, HEADING, SPEED

SAFE = FinCommand(math.radians(15.0), 0.0, 600.0)


RAW = {
    "vehicle_id": "auv_1",
    "address": 1,
    "fleet_size": 1,
    "controller": {"kind": "autopilot"},
    "course": {"kind": "steps"},
    "report": {"kind": "exact"},
}


def config(**changes):
    """Return the configuration with changes; None leaves a key out."""
    raw = {key: value for key, value in {**RAW, **changes}.items() if value is not None}
    return load(AgentConfig, raw, "agent")


def nav_at(tick, position=(0.0, 0.0, 10.0), **changes):
    nu = (1.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    return VehicleState(tick, position, quaternion_from_heading(0.0), nu)._replace(**changes)


def inbox(tick, *, asks=False):
    return Inbox(tick, asks, ())


def test_it_steers_by_its_course():
    agent = Agent(config())
    assert agent.command == "fins"
    assert not agent.flocks
    before, _ = agent.step(9.9, nav_at(99), inbox(99))
    after, _ = agent.step(10.0, nav_at(100), inbox(100))
    assert before == pytest.approx((0.0, 0.0, 895.5), abs=1e-9)
    assert isinstance(after, FinCommand)
    assert after.rudder_rad == pytest.approx(math.radians(15.0))
    assert agent.law_state[HEADING] == pytest.approx(math.radians(30.0))
    assert (agent.law_state[DEPTH], agent.law_state[SPEED], agent.law_state[CROSS_TRACK]) == (20.0, 1.5, 0.0)
    assert agent.reference.velocity == pytest.approx((1.5 * math.cos(math.pi / 6), 0.75, 0.0))


def test_it_notes_how_far_it_is_beside_its_path():
    agent = Agent(config(course={"kind": "line_of_sight"}))
    command, _ = agent.step(0.0, nav_at(0, (50.0, 4.0, 30.0)), inbox(0))
    assert agent.law_state[CROSS_TRACK] == pytest.approx(4.0)
    assert isinstance(command, FinCommand)
    assert command.rudder_rad < 0.0, "to port, towards the path"


def test_without_a_usable_navigation_it_circles():
    agent = Agent(config())
    for nav in (None, nav_at(0, is_valid=False), nav_at(0, nu=(math.nan,) * 6)):
        command, packets = agent.step(0.0, nav, inbox(0, asks=True))
        assert (command, packets) == (SAFE, [])
        assert agent.holding


def test_its_circle_keeps_its_depth():
    model = remus()
    state = model.initial_state((0.0, 0.0, 30.0), 0.0, 1.5)
    depths = []
    for _ in range(3):
        state = model.step(state, model.limited_command(tuple(SAFE)), STILL, 0.05, 1200)
        depths.append(state[2])
    assert depths == pytest.approx([30.0, 30.0, 30.0], abs=0.06)
    assert model.flown_turn(600.0).radius_m == pytest.approx(23.9, abs=0.2)


def test_a_failed_computer_sends_nothing_and_knows_nothing():
    agent = Agent(config(fails_at_s=5.0))
    _, packets = agent.step(4.9, nav_at(49), inbox(49, asks=True))
    assert len(packets) == 1
    _, packets = agent.step(5.0, nav_at(50), inbox(50, asks=True))
    assert packets == []
    assert agent.holding == "failed computer"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"course": None}, r"^agent\.course: missing; allowed: a section, since the controller autopilot"),
        ({"reference": {"kind": "circle"}}, r"^agent\.reference: 'circle' is not allowed; allowed: nothing"),
        (
            {"flocking": {"kind": "potential"}},
            r"^agent\.flocking: 'potential' is not allowed; allowed: nothing",
        ),
        (
            {"controller": {"kind": "pfpd"}, "reference": {"kind": "circle"}},
            r"^agent\.course: 'steps' is not allowed; allowed: nothing, since the controller pfpd",
        ),
    ],
)
def test_parts_that_do_not_fit_are_refused(changes, words):
    with pytest.raises(ConfigError, match=words):
        config(**changes)
