"""Claims about an agent whose measurement or law fails: it says so, gives the safe command, and goes on."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.messages import Inbox, VehicleState, VelocityCommand, Wrench, command_numbers
from auv_core.params import ConfigError, load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.holding import BAD_NAVIGATION, NO_FINITE_COMMAND

SAFE_WRENCH = Wrench((0.0,) * 6)
SAFE_VELOCITY = VelocityCommand((0.0,) * 3, 0.0)
FLOCK = {
    "flocking": {"kind": "potential"},
    "separation": {"kind": "mathematical"},
    "consensus": {"kind": "thesis"},
    "controller": {"kind": "velocity_direct"},
}
PATH = {"controller": {"kind": "pfpd", "params": {"frame": "body"}}}
NUMBERS = st.sampled_from([math.nan, math.inf, -math.inf, 1e308, -1e308, 0.0, 1.0])


def agent(parts, **changes):
    raw = {"vehicle_id": "auv_1", "address": 1, "fleet_size": 1, "reference": {"kind": "circle"}}
    return Agent(load(AgentConfig, {**raw, **parts, **changes}, "agent"))


def nav(tick=0, position=(0.0, 9.0, 10.0), nu=(0.1, 0.0, 0.0, 0.0, 0.0, 0.0), *, is_valid=True):
    return VehicleState(tick, position, (1.0, 0.0, 0.0, 0.0), nu, is_valid)


def inbox(tick=0):
    return Inbox(tick, True, ())


@pytest.mark.parametrize(
    ("parts", "safe"), [(FLOCK, SAFE_VELOCITY), (PATH, SAFE_WRENCH)], ids=["flock", "path"]
)
@pytest.mark.parametrize(
    "bad",
    [nav(position=(math.nan, 0.0, 0.0)), nav(nu=(math.inf, 0.0, 0.0, 0.0, 0.0, 0.0)), nav(is_valid=False)],
    ids=["nan", "infinite", "marked"],
)
def test_without_a_usable_measurement_the_command_is_safe_and_nothing_is_sent(parts, safe, bad):
    vehicle = agent(parts)
    command, packets = vehicle.step(0.0, bad, inbox())
    assert (command, packets) == (safe, [])
    assert vehicle.holding.startswith(BAD_NAVIGATION)
    command, packets = vehicle.step(0.1, nav(1), inbox(1))
    assert command != safe
    assert (len(packets), vehicle.holding) == (1, "")


@settings(max_examples=200, deadline=None)
@given(st.tuples(NUMBERS, NUMBERS, NUMBERS), st.tuples(*[NUMBERS] * 6), st.sampled_from([FLOCK, PATH]))
def test_no_measurement_makes_a_command_that_is_not_finite(position, nu, parts):
    vehicle = agent(parts)
    for tick in range(3):
        command, _ = vehicle.step(0.1 * tick, nav(tick, position, nu), inbox(tick))
        assert all(math.isfinite(number) for number in command_numbers(command))


@pytest.mark.parametrize("number", [math.nan, -math.inf, 1e300, -2e9])
def test_a_law_that_gives_no_finite_wrench_is_named_and_its_memory_kept(number, monkeypatch):
    vehicle = agent(PATH)
    monkeypatch.setattr(vehicle.task.law, "evaluate", lambda state, view: ((0.0, number, *[0.0] * 4), ()))
    command, packets = vehicle.step(0.0, nav(), inbox())
    assert (command, vehicle.holding, len(packets)) == (SAFE_WRENCH, NO_FINITE_COMMAND, 1)


def test_a_law_that_divides_by_nothing_is_named(monkeypatch):
    def broken(state, view):
        raise ZeroDivisionError

    vehicle = agent(PATH)
    monkeypatch.setattr(vehicle.task.law, "evaluate", broken)
    assert vehicle.step(0.0, nav(), inbox())[0] == SAFE_WRENCH
    assert vehicle.holding == NO_FINITE_COMMAND


def test_a_law_of_its_own_believes_in_no_flock():
    vehicle = agent(PATH)
    vehicle.step(0.0, nav(), inbox())
    assert not vehicle.flocks
    assert vehicle.knows_path
    assert vehicle.centre == nav().position
    assert vehicle.reference.velocity == pytest.approx((0.1, 0.0, 0.0))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({**FLOCK, "consensus": None}, "agent.consensus: missing; allowed: a section, since the controller"),
        ({**PATH, "separation": FLOCK["separation"]}, "agent.separation: 'mathematical' is not allowed"),
        (
            {**PATH, "reference": None},
            "agent.reference: missing; allowed: a section, since the controller pfpd",
        ),
    ],
    ids=["flock without consensus", "path with separation", "no path"],
)
def test_parts_that_do_not_fit_together_are_refused(changes, said):
    with pytest.raises(ConfigError) as refusal:
        agent(changes)
    assert str(refusal.value).startswith(said)


@pytest.mark.parametrize("report", ["exact", "compact"])
def test_a_belief_that_is_no_number_is_not_sent_and_is_counted(report, monkeypatch):
    one = agent(FLOCK, report={"kind": report})
    assert len(one.step(0.0, nav(), inbox())[1]) == 1
    monkeypatch.setattr(Agent, "centre", (math.nan, 0.0, 0.0))
    command, packets = one.step(0.1, nav(1), inbox(1))
    assert packets == []
    assert one.unsent == 1
    assert math.isfinite(sum(command_numbers(command)))
