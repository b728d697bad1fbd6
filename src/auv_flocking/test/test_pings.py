"""Claims about what a law sees of the own sonar: directions from north, with their age."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.geometry import added, distance, limited, quaternion_from_heading
from auv_core.messages import Inbox, SonarContact, VehicleState
from auv_core.params import load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.flocking import potential
from auv_flocking.pings import echoes_of

MODERATE = settings(max_examples=60, deadline=None)
PERIOD_S = 0.1
HERE = (1.0, 9.0, 10.0)


def nav_at(tick, heading_rad=0.0):
    return VehicleState(tick, HERE, quaternion_from_heading(heading_rad), (0.0,) * 6)


class Wary(potential.Flocking):
    """The flocking law of the thesis, which also keeps 3 m from whatever the sonar shows within a second."""

    def velocity(self, view):
        asked = super().velocity(view)
        if view.ping.age_s > 1.0:
            return asked
        for echo in view.ping.echoes:
            if 0.0 < echo.range_m < 3.0:
                away = (1.0 - echo.range_m / 3.0) / echo.range_m
                x, y, z = echo.relative_ned_m
                asked = added(asked, (-away * x, -away * y, -away * z))
        return limited(asked, 1.0)


def wary_agent(monkeypatch, **changes):
    monkeypatch.setattr(potential, "Flocking", Wary)
    raw = {
        "vehicle_id": "auv_1",
        "address": 1,
        "fleet_size": 1,
        "reference": {"kind": "circle"},
        "flocking": {"kind": "potential"},
        "separation": {"kind": "mathematical"},
        "consensus": {"kind": "thesis", "params": {"carried_by": "flock"}},
        "report": {"kind": "exact"},
        "controller": {"kind": "velocity_direct"},
        "has_sonar": True,
    }
    return Agent(load(AgentConfig, {**raw, **changes}, "agent"))


def asked(agent, tick, *contacts):
    agent.step(tick * PERIOD_S, nav_at(tick, 0.5 * math.pi), Inbox(tick, False, (), contacts))
    return agent.reference.velocity


@MODERATE
@given(st.floats(0.1, 50.0), st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_an_echo_is_where_the_contact_is_whatever_the_heading(
    range_m, bearing_rad, elevation_rad, heading_rad
):
    (echo,) = echoes_of(nav_at(0, heading_rad), (SonarContact(range_m, bearing_rad, elevation_rad),))
    assert echo.range_m == pytest.approx(range_m)
    assert echo.elevation_rad == pytest.approx(elevation_rad, abs=1e-6)
    turned_rad = math.remainder(echo.bearing_rad - bearing_rad - heading_rad, 2.0 * math.pi)
    assert turned_rad == pytest.approx(0.0, abs=1e-6)
    assert distance(echo.relative_ned_m, (0.0, 0.0, 0.0)) == pytest.approx(range_m)


def test_what_cannot_be_is_no_echo():
    bad = (SonarContact(math.nan, 0.0, 0.0), SonarContact(-1.0, 0.0, 0.0), SonarContact(1.0, 0.0, 2.0))
    assert echoes_of(nav_at(0), bad) == ()


def test_a_law_moves_away_from_a_contact_until_it_is_old(monkeypatch):
    agent, calm = wary_agent(monkeypatch), wary_agent(monkeypatch)
    steps_m = []
    for tick in range(15):
        contacts = (SonarContact(1.0, 0.0, 0.0),) if tick == 2 else ()  # ahead, and the bow points east
        with_it, without = asked(agent, tick, *contacts), asked(calm, tick)
        steps_m.append(with_it[1] - without[1])
    assert steps_m[:2] == [0.0, 0.0]
    assert max(steps_m[2:12]) < -0.1
    assert steps_m[13:] == [0.0, 0.0]


def test_a_vehicle_without_sonar_has_no_ping(monkeypatch):
    agent, calm = wary_agent(monkeypatch, has_sonar=False), wary_agent(monkeypatch)
    assert asked(agent, 0, SonarContact(1.0, 0.0, 0.0)) == asked(calm, 0)
