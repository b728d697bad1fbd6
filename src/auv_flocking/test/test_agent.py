"""Claims about the agent, the software of one vehicle."""

import math

import numpy as np
import pytest

from auv_core.messages import Inbox, Packet, Reception, VehicleState, VelocityCommand
from auv_core.params import ConfigError, load
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.heard import within_s
from auv_flocking.report import Report
from auv_flocking.reports import exact, make_format

PERIOD_S = 0.1
FORMAT = exact.Format(exact.Params(), ())


def _config(**changes):
    raw = {
        "vehicle_id": "auv_1",
        "address": 1,
        "fleet_size": 3,
        "is_leader": True,
        "period_s": PERIOD_S,
        "reference": {"kind": "circle"},
        "flocking": {"kind": "potential"},
        "separation": {"kind": "mathematical"},
        "consensus": {"kind": "thesis", "params": {"carried_by": "flock"}},
        "report": {"kind": "exact"},
        "controller": {"kind": "velocity_direct"},
    }
    return load(AgentConfig, {**raw, **changes}, "agent")


def _nav(tick, position=(1.0, 9.0, 10.0), nu=(0.1, 0.0, 0.0, 0.0, 0.0, 0.0)):
    return VehicleState(tick, position, (1.0, 0.0, 0.0, 0.0), nu)


def _heard(tick, address, position=(3.0, 9.0, 10.0), *, time_s=None, payload=None):
    if payload is None:
        time_s = (tick - 1) * PERIOD_S if time_s is None else time_s
        payload = FORMAT.encode(Report(address, time_s, position, (0.0,) * 3, position, (0.0,) * 3))
    return Reception(Packet(tick - 1, address, 0, tick, payload), 0.0, 0.0, math.nan)


def _inbox(tick, *receptions, ready=False):
    return Inbox(tick, ready, receptions)


def _step(agent, tick, *receptions, ready=False, nav=None):
    return agent.step(tick * PERIOD_S, nav or _nav(tick), _inbox(tick, *receptions, ready=ready))


def _flight(agent, ticks=60):
    """Return all outputs of the agent over some ticks with changing neighbours."""
    said = []
    for tick in range(ticks):
        receptions = [_heard(tick, 2 + tick % 2, (3.0 + 0.01 * tick, 8.0, 10.5))] if tick % 5 == 1 else []
        command, packets = _step(agent, tick, *receptions, ready=tick % 4 == 0)
        said.append((command, packets, agent.centre, agent.reference, [e.position for e in agent.neighbours]))
    return said


@pytest.mark.parametrize("controller", ["velocity_direct", "velocity_pi"])
def test_the_same_inputs_give_the_same_outputs_to_the_last_bit(controller):
    config = _config(controller={"kind": controller})
    assert repr(_flight(Agent(config))) == repr(_flight(Agent(config)))


def test_it_hands_over_a_packet_only_when_the_modem_asks():
    agent = Agent(_config())
    sent = [len(_step(agent, tick, ready=tick in (3, 7, 8))[1]) for tick in range(12)]
    assert [tick for tick, count in enumerate(sent) if count] == [3, 7, 8]
    assert max(sent) == 1


def test_its_packets_are_numbered_addressed_to_everybody_and_of_the_report_s_length():
    agent = Agent(_config(address=2))
    packets = [_step(agent, tick, ready=True)[1][0] for tick in range(5)]
    assert [packet.sequence for packet in packets] == [1, 2, 3, 4, 5]
    assert {(packet.source, packet.destination, len(packet.payload)) for packet in packets} == {
        (2, 0, FORMAT.payload_bytes)
    }
    assert [packet.tick for packet in packets] == [0, 1, 2, 3, 4]


def test_its_report_says_where_it_is_how_fast_and_what_it_believes():
    agent = Agent(_config())
    east = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    nav = VehicleState(4, (1.0, 2.0, 3.0), east, (0.2, 0.0, 0.1, 0.0, 0.0, 0.0), is_bounded=True)
    (packet,) = agent.step(0.4, nav, _inbox(4, ready=True))[1]
    report = FORMAT.decode(packet.payload, 0.0)
    assert (report.address, report.time_s) == (1, 0.4)
    assert report.position == (1.0, 2.0, 3.0)
    assert report.velocity == pytest.approx((0.0, 0.2, 0.1), abs=1e-6)
    np.testing.assert_allclose(report.centre, agent.centre, rtol=1e-6)
    np.testing.assert_allclose(report.flock_velocity, agent.flock_velocity.velocity, rtol=1e-6)
    assert report.flock_stamp_s == agent.flock_velocity.stamp_s == 0.4
    assert report.flock_turn_rate_radps == agent.flock_velocity.turn_rate_radps
    assert report.heading_rad == pytest.approx(0.5 * math.pi, abs=1e-6)
    assert (report.position_sd_m, report.is_bounded) == (0.0, True)
    assert (report.is_holding, report.heard_mask) == (False, 0)


def test_its_report_says_that_it_waits_and_whom_it_has_heard_within_which_time():
    agent = Agent(_config(hold_s=60.0))
    (packet,) = _step(agent, 40, _heard(40, 3, time_s=1.5), ready=True)[1]
    report = FORMAT.decode(packet.payload, 0.0)
    assert (report.is_holding, report.heard_mask) == (True, 0b100)
    assert report.heard_code is not None
    assert within_s(report.heard_code - 1) < 2.5 <= within_s(report.heard_code)
    (packet,) = _step(agent, 41, _heard(41, 2), ready=True)[1]
    report = FORMAT.decode(packet.payload, 0.0)
    assert (report.is_holding, report.heard_mask) == (False, 0b110)


def test_its_report_says_that_it_stays_until_it_is_in_its_layer():
    layered = {"kind": "communication_aware", "params": {"layer_depth_m": 10.0}}
    agent = Agent(_config(flocking=layered))
    _step(agent, 39, _heard(39, 2), _heard(39, 3))
    for depth_m, stays in ((10.0, True), (8.5, False), (9.0, False)):
        (packet,) = _step(agent, 40, ready=True, nav=_nav(40, (1.0, 9.0, depth_m)))[1]
        assert FORMAT.decode(packet.payload, 0.0).is_holding == stays, depth_m


def test_it_holds_station_until_all_neighbours_were_heard():
    agent = Agent(_config(hold_s=10.0))
    asked = []
    for tick in range(30):
        receptions = {5: [_heard(5, 2)], 12: [_heard(12, 3)]}.get(tick, [])
        _step(agent, tick, *receptions)
        asked.append(agent.reference.velocity)
    assert all(velocity == (0.0, 0.0, 0.0) for velocity in asked[:12])
    assert all(velocity != (0.0, 0.0, 0.0) for velocity in asked[12:])


def test_it_holds_station_no_longer_than_allowed():
    agent = Agent(_config(hold_s=1.0))
    asked = []
    for tick in range(20):
        _step(agent, tick)
        asked.append(agent.reference.velocity != (0.0, 0.0, 0.0))
    assert asked == [False] * 10 + [True] * 10


def test_alone_it_does_not_wait():
    agent = Agent(_config(fleet_size=1, hold_s=10.0))
    _step(agent, 0)
    assert agent.reference.velocity != (0.0, 0.0, 0.0)


def test_its_first_belief_of_the_centre_is_its_own_place():
    agent = Agent(_config())
    _step(agent, 0, nav=_nav(0, (4.0, 5.0, 6.0)))
    assert agent.centre == (4.0, 5.0, 6.0)


def test_its_belief_of_the_centre_goes_to_the_middle_between_it_and_what_it_hears():
    """At rest with one neighbour whose estimate is b: c = (own + b) / 2."""
    agent = Agent(_config(fleet_size=2))
    own = (0.0, 0.0, 10.0)
    for tick in range(400):
        agent.step(
            tick * PERIOD_S, _nav(tick, own, (0.0,) * 6), _inbox(tick, _heard(tick, 2, (4.0, 2.0, 10.0)))
        )
    assert agent.centre == pytest.approx((2.0, 1.0, 10.0), abs=1e-6)


def test_it_gives_way_to_a_neighbour_that_is_near():
    near, far = Agent(_config()), Agent(_config())
    _step(near, 1, _heard(1, 2, (2.0, 9.0, 10.0)))
    _step(far, 1, _heard(1, 2, (6.0, 9.0, 10.0)))
    assert near.reference.velocity[0] < far.reference.velocity[0] - 1.0


def test_it_gives_way_to_an_obstacle():
    clear = Agent(_config())
    beside = Agent(_config(obstacles_ned_m=[2.0, 9.0, 10.0], obstacle_safety_distances_m=[2.0]))
    _step(clear, 0)
    _step(beside, 0)
    assert np.subtract(clear.reference.velocity, beside.reference.velocity) == pytest.approx((6.0, 0.0, 0.0))


def test_bytes_that_are_no_report_are_counted_and_change_nothing():
    clean, noisy = Agent(_config()), Agent(_config())
    _step(clean, 1, _heard(1, 2))
    _step(
        noisy,
        1,
        _heard(1, 3, payload=b"noise"),
        _heard(1, 2),
        _heard(1, 3, payload=bytes(FORMAT.payload_bytes)),
    )
    assert noisy.rejected == 2
    assert noisy.reference == clean.reference


def test_the_command_is_what_the_controller_makes_of_the_reference():
    agent = Agent(_config())
    command, _ = _step(agent, 0)
    assert isinstance(command, VelocityCommand)
    assert command.velocity == agent.reference.velocity
    assert agent.command == "velocity"
    assert Agent(_config(controller={"kind": "velocity_pi"})).command == "wrench"


def test_a_leader_alone_follows_the_path_behind_by_the_lag_of_its_consensus():
    """The centre lags by v / k = 0.1 m; cohesion then pulls back as much as the path pulls ahead."""
    agent = Agent(_config(fleet_size=1))
    position = np.array([3.0, 7.0, 8.0])
    for tick in range(600):
        command, _ = agent.step(tick * PERIOD_S, _nav(tick, tuple(map(float, position))), _inbox(tick))
        assert isinstance(command, VelocityCommand)
        position = position + PERIOD_S * np.array(command.velocity)
    point = agent.path_point(60.0)
    assert point is not None
    assert math.dist(position, point.position) == pytest.approx(0.1, abs=0.01)


def test_obstacles_need_three_numbers_and_a_distance_each():
    with pytest.raises(
        ConfigError, match=r"^agent\.obstacles_ned_m: 2 numbers are not allowed; allowed: three"
    ):
        _config(obstacles_ned_m=[1.0, 2.0], obstacle_safety_distances_m=[2.0])


def test_a_packet_that_speaks_for_another_vehicle_is_rejected():
    agent = Agent(_config())
    honest = _heard(1, 3)
    lying = Reception(Packet(0, 2, 0, 1, honest.packet.payload), 0.0, 0.0, math.nan)
    _step(agent, 1, lying)
    assert (agent.rejected, len(agent.neighbours)) == (1, 0)
    _step(agent, 2, honest)
    assert (agent.rejected, len(agent.neighbours)) == (1, 1)


def test_coarse_reports_are_believed_no_more_than_their_rounding_allows():
    coarse = {"kind": "compact", "params": {"position_resolution_m": 1.0}}
    variances = []
    for report in ({"kind": "compact"}, coarse):
        agent = Agent(_config(report=report))
        form = make_format(agent._config.report)
        zero = (0.0, 0.0, 0.0)
        payload = form.encode(Report(2, 0.0, (3.0, 9.0, 10.0), zero, (3.0, 9.0, 10.0), zero))
        _step(agent, 0, _heard(0, 2, payload=payload))
        variances.append(agent.neighbours[0].covariance[0, 0])
    assert variances[0] == pytest.approx(0.006**2)
    assert pytest.approx(0.02**2 / 12.0, rel=0.1) == 0.006**2
    assert variances[1] == pytest.approx(1.0 / 12.0)


def test_a_computer_that_fails_gives_the_safe_command_and_is_silent():
    agent = Agent(_config(fails_at_s=0.5))
    for tick in range(12):
        command, packets = _step(agent, tick, ready=True)
        has_failed = tick * PERIOD_S >= 0.5
        assert len(packets) == (not has_failed)
        assert (agent.holding == "failed computer") == has_failed
        assert (command == VelocityCommand((0.0, 0.0, 0.0), 0.0)) == has_failed
