"""Claims about an agent's inputs: what is old or impossible gives the safe command, is named and counted."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.messages import Inbox, Packet, Reception, SonarContact, VehicleState, command_numbers
from auv_core.params import ConfigError, load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.holding import (
    BAD_NAVIGATION,
    CAUSES,
    OUT_OF_REPORT,
    SILENT_MODEM,
    STALE_NAVIGATION,
    cause_number,
)
from auv_flocking.packet_judge import refusal_words
from auv_flocking.report import Report
from auv_flocking.reports import compact, exact

PERIOD_S = 0.1
SAFE = (0.0,) * 6
EXACT = exact.Format(exact.Params(), ())
ANYTHING = st.one_of(st.floats(width=64), st.sampled_from([0.0, 1.0, -1.0, 1e5]))


def agent(**changes):
    raw = {
        "vehicle_id": "auv_1",
        "address": 1,
        "fleet_size": 2,
        "fleet_ids": ["auv_1", "auv_2"],
        "reference": {"kind": "circle"},
        "flocking": {"kind": "potential"},
        "separation": {"kind": "mathematical"},
        "consensus": {"kind": "thesis", "params": {"carried_by": "flock"}},
        "report": {"kind": "exact"},
        "controller": {"kind": "velocity_direct"},
    }
    return Agent(load(AgentConfig, {**raw, **changes}, "agent"))


def nav(tick, **changes):
    state = VehicleState(tick, (0.0, 9.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
    return state._replace(**changes)


def inbox(tick, *receptions, contacts=()):
    return Inbox(tick, True, receptions, contacts)


def step(one, tick, state, *, inbox_tick=None):
    """Return the six numbers of the command and the packets."""
    heard = inbox(tick if inbox_tick is None else inbox_tick)
    command, packets = one.step(tick * PERIOD_S, state, heard)
    return command_numbers(command), packets


def packet(tag_s, source=2, address=2, position=(3.0, 9.0, 10.0)):
    zero = (0.0, 0.0, 0.0)
    report = Report(address, tag_s, position, zero, zero, zero)
    return Reception(Packet(0, source, 0, 1, EXACT.encode(report)), 0.0, 0.0, math.nan)


def test_navigation_that_falls_silent_gives_the_safe_command_after_its_limit_and_recovers():
    one = agent()
    held = []
    for tick in range(30):
        command, packets = step(one, tick, nav(min(tick, 10)))
        held.append(bool(one.holding))
        assert (command == SAFE) == (packets == []) == held[-1]
    assert held == [False] * 16 + [True] * 14  # 0.5 s after tick 10, and one period
    assert one.holding == f"{STALE_NAVIGATION}: 1.9 s old, allowed: 0.5 s"
    assert step(one, 30, nav(30))[0] != SAFE
    assert one.holding == ""


def test_no_navigation_at_all_is_named():
    one = agent()
    assert step(one, 0, None) == (SAFE, [])
    assert one.holding == f"{STALE_NAVIGATION}: none came"


def test_navigation_from_the_future_is_named():
    one = agent()
    assert step(one, 5, nav(10**9))[0] == SAFE
    assert one.holding == f"{STALE_NAVIGATION}: 99999999.5 s in the future, allowed: 0.5 s"


def test_the_limit_of_the_navigation_is_a_parameter():
    one = agent(inputs={"nav_max_age_s": 3.0})
    assert step(one, 30, nav(0))[0] != SAFE
    assert step(one, 31, nav(0))[0] == SAFE


@pytest.mark.parametrize(("fleet_size", "holds"), [(2, True), (1, False)])
def test_a_modem_that_falls_silent_holds_the_vehicles_of_a_fleet(fleet_size, holds):
    one = agent(fleet_size=fleet_size, fleet_ids=[])
    step(one, 0, nav(0))
    assert (step(one, 6, nav(6), inbox_tick=0)[0] == SAFE) == holds
    assert one.holding == (f"{SILENT_MODEM}: last inbox 0.6 s old, allowed: 0.5 s" if holds else "")


@pytest.mark.parametrize(
    ("parts", "position", "axis"),
    [
        ("compact", (5300.0, 0.0, 10.0), "north 5300.0 m, allowed: -5242.88 to 5242.86 m"),
        ("compact", (0.0, 0.0, 1147.0), "down 1147.0 m, allowed: -10.24 to 645.1 m"),
        ("compact", (0.0, -5243.0, 0.0), "east -5243.0 m, allowed: -5242.88 to 5242.86 m"),
    ],
)
def test_a_position_that_no_report_carries_holds_the_vehicle(parts, position, axis):
    one = agent(report={"kind": parts})
    assert step(one, 0, nav(0, position=position)) == (SAFE, [])
    assert one.holding == f"{OUT_OF_REPORT}: {axis}"
    assert one.saturated == 0


def test_alone_nobody_is_misled_by_a_position_out_of_bounds():
    one = agent(fleet_size=1, fleet_ids=[], report={"kind": "compact"})
    assert step(one, 0, nav(0, position=(6000.0, 0.0, 10.0)))[0] != SAFE


@pytest.mark.parametrize("form", [compact.Format(compact.Params(), ()), EXACT], ids=["compact", "exact"])
def test_a_position_within_the_bounds_of_a_format_does_not_saturate(form):
    zero = (0.0, 0.0, 0.0)
    for position in form.carries.position:
        form.encode(Report(1, 0.0, position, zero, position, zero))
    assert form.saturated == 0


def test_skewed_clocks_are_named_with_sender_reason_duration_and_count():
    one = agent()
    for tick in range(5):
        one.step(tick * PERIOD_S, nav(tick), inbox(tick, packet(tick * PERIOD_S + 2.1)))
    assert refusal_words(one.refusals, ["auv_1", "auv_2"], 4 * PERIOD_S) == [
        "auv_2: time tag 2.1 s in the future, allowed: 1 s, for 0.4 s, 5 packets"
    ]
    assert one.rejected == 5
    one.step(0.5, nav(5), inbox(5, packet(0.4)))
    assert one.refusals == {}


@pytest.mark.parametrize(
    ("reception", "words"),
    [
        (packet(-3.0), "auv_2: time tag 3.0 s before the start of the run"),
        (packet(0.0, address=1, source=1), "auv_1: it has this vehicle's own address"),
        (packet(0.0, address=9, source=9), "address 9: address 9, allowed: 1 to 2"),
        (packet(0.0, position=(1e8, 0.0, 0.0)), "auv_2: a place 1e+08 m from the origin, allowed: 1e+06 m"),
        (packet(0.0, address=2, source=1), "auv_1: its report has address 2"),
        (
            Reception(Packet(0, 2, 0, 1, b"noise"), 0.0, 0.0, math.nan),
            "auv_2: version 6; this format reads 0 and 5",
        ),
    ],
)
def test_a_refused_packet_says_why(reception, words):
    one = agent()
    one.step(0.0, nav(0), inbox(0, reception))
    (line,) = refusal_words(one.refusals, ["auv_1", "auv_2"], 0.0)
    assert line.startswith(words)
    assert line.endswith(", for 0.0 s, 1 packet")


@pytest.mark.parametrize(
    "contact",
    [
        SonarContact(2.0, math.inf, 0.0),
        SonarContact(2.0, 0.0, math.nan),
        SonarContact(-1.0, 0.0, 0.0),
        SonarContact(0.0, 0.0, 0.0),
        SonarContact(1e300, 0.0, 0.0),
        SonarContact(2.0, 0.0, 2.0),
    ],
)
def test_a_contact_that_can_be_none_is_left_out_and_counted(contact):
    one = agent()
    good = SonarContact(3.0, 0.0, 0.0)
    one.step(0.0, nav(0), inbox(0, packet(0.0)))
    command, _ = one.step(0.1, nav(1), inbox(1, contacts=(contact, good)))
    assert one.contacts_refused == 1
    assert all(map(math.isfinite, command_numbers(command)))
    assert one.holding == ""


def test_without_a_sonar_contacts_change_nothing_and_are_counted():
    blind, seeing = agent(has_sonar=False), agent()
    contacts = (SonarContact(3.0, 0.0, 0.0), SonarContact(3.0, 0.1, 0.0))
    commands = []
    for one, seen in ((blind, contacts), (seeing, ())):
        one.step(0.0, nav(0), inbox(0, packet(0.0)))
        commands.append([one.step(0.1 * k, nav(k), inbox(k, contacts=seen))[0] for k in range(1, 5)])
    assert commands[0] == commands[1]
    assert blind.contacts_refused == 8


NAVS = st.builds(
    VehicleState,
    tick=st.one_of(st.integers(-5, 40), st.integers(-(2**63), 2**63 - 1)),
    position=st.tuples(*[ANYTHING] * 3),
    attitude=st.one_of(st.just((1.0, 0.0, 0.0, 0.0)), st.tuples(*[ANYTHING] * 4)),
    nu=st.tuples(*[ANYTHING] * 6),
    is_valid=st.booleans(),
    position_sd_m=ANYTHING,
    heading_sd_rad=ANYTHING,
)
CONTACTS = st.lists(st.builds(SonarContact, ANYTHING, ANYTHING, ANYTHING), max_size=3).map(tuple)
FLEETS = [
    {},
    {"flocking": {"kind": "communication_aware"}, "consensus": {"kind": "neighbour_mean"}},
    {"controller": {"kind": "velocity_pi"}},
]


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(FLEETS), st.lists(st.tuples(st.none() | NAVS, CONTACTS), min_size=1, max_size=8))
def test_no_input_makes_a_command_that_is_not_finite_and_old_ones_make_the_safe_one(parts, inputs):
    one = agent(**parts)
    one.step(0.0, nav(0), inbox(0, packet(0.0)))
    for tick, (state, contacts) in enumerate(inputs, start=1):
        command, packets = one.step(tick * PERIOD_S, state, inbox(tick, contacts=contacts))
        numbers = command_numbers(command)
        assert all(map(math.isfinite, numbers))
        if state is None or not -5 <= tick - state.tick <= 5:
            assert (numbers, packets) == (SAFE, [])
            assert one.holding.startswith(STALE_NAVIGATION)
        elif not state.is_valid:
            assert one.holding.startswith(BAD_NAVIGATION)


def test_names_for_another_number_of_vehicles_are_refused():
    with pytest.raises(ConfigError, match=r"fleet_ids: 2 names are not allowed; allowed: 3, or none"):
        agent(fleet_size=3)


def test_every_cause_has_its_number():
    assert cause_number("") == 0
    assert [cause_number(f"{cause}: more") for cause in CAUSES] == list(range(1, len(CAUSES) + 1))
    assert cause_number("a text of another version") == len(CAUSES) + 1
