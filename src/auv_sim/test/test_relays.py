"""Claims about when a relay begins a tick, and about what it then does."""

from typing import Any

import pytest

from auv_core.messages import Packet, VehicleState
from auv_sim.relay.lock_step import LockStepRelay
from auv_sim.relay.real_time import RealTimeRelay
from auv_sim.relay.silences import Silences
from auv_sim.relay.state_watch import StateWatch

PERIOD_S, SILENCE_S = 0.1, 3.0
HELLO = Packet(tick=0, source=1, destination=0, sequence=0, payload=b"hello")


def state(tick, north_m=0.0):
    return VehicleState(tick, (north_m, 0.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)


class FakeWater:
    """Notes what a relay does; `runs` is whether the run continues."""

    def __init__(self):
        self.done: list[Any] = []
        self.hulls: dict[int, VehicleState] = {}
        self.runs = True

    def transmit(self, vehicle, packets, states):
        if packets:
            self.done.append(("transmit", vehicle, [each.tick for each in states]))

    def begin_tick(self, tick, states):
        self.done.append(("tick", tick, [each.tick for each in states]))
        return self.runs

    def lose(self, vehicle, state):
        self.hulls[vehicle] = state

    def drift(self, vehicle):
        hull = self.hulls[vehicle] = self.hulls[vehicle]._replace(tick=self.hulls[vehicle].tick + 1)
        self.done.append(("drift", vehicle, hull.tick))
        return hull

    def take(self):
        taken, self.done = self.done, []
        return taken


class FakeTicks:
    """A steady clock that tests set."""

    tick = 0

    def tick_now(self):
        return self.tick

    def tick_now_or(self, _):
        return self.tick

    def steady_s(self):
        return self.tick * PERIOD_S


@pytest.fixture
def water():
    return FakeWater()


def lock_step(water, may_begin=lambda: True):
    relay = LockStepRelay(2, water, may_begin)
    relay.hear_state(0, state(0))
    relay.hear_state(1, state(0))
    return relay


def test_lock_step_begins_a_tick_with_the_last_answer_and_sends_in_the_order_of_vehicles(water):
    relay = lock_step(water)
    assert water.take() == [("tick", 0, [0, 0])]
    relay.hear_packets(1, 0, [HELLO])
    relay.hear_state(1, state(1))
    relay.hear_state(0, state(1))
    assert (relay.tick, water.take()) == (0, [])
    assert relay.owed() == [("agent_node", 0)]
    relay.hear_packets(0, 0, [HELLO])
    assert relay.tick == 1
    assert water.take() == [("transmit", 0, [0, 0]), ("transmit", 1, [0, 0]), ("tick", 1, [1, 1])]


def test_lock_step_waits_until_the_run_allows_a_tick(water):
    allowed: list[bool] = []
    relay = lock_step(water, lambda: bool(allowed))
    assert (relay.advance(), relay.tick) == (False, -1)
    allowed.append(True)
    assert (relay.advance(), relay.tick) == (True, 0)


@pytest.mark.parametrize("has_moved", [False, True])
def test_lock_step_goes_on_without_a_vehicle_and_its_hull_drifts(water, has_moved):
    relay = lock_step(water)
    relay.hear_state(0, state(1))
    relay.hear_packets(0, 0, [])
    if has_moved:
        relay.hear_state(1, state(1))
    water.take()
    assert relay.drop() == [1]
    assert water.take() == ([] if has_moved else [("drift", 1, 1)])
    assert relay.advance()
    assert water.take() == [("tick", 1, [1, 1]), ("drift", 1, 2)]
    assert relay.owed() == [("agent_node", 0)]


def test_hulls_stop_with_the_run(water):
    relay = lock_step(water)
    relay.hear_state(0, state(1))
    relay.hear_packets(0, 0, [])
    relay.drop()
    water.take()
    water.runs = False
    assert relay.advance()
    assert water.take() == [("tick", 1, [1, 1])]


class Case:
    """A relay in real time with its clock."""

    def __init__(self, water):
        self.ticks = FakeTicks()
        self.watch = StateWatch(["auv_1", "auv_2"], 0.5, PERIOD_S)
        silences = Silences(2, SILENCE_S)
        self.relay = RealTimeRelay(
            water, self.watch, silences, self.ticks, self.ticks.steady_s, may_begin=lambda: True
        )

    def all_answer(self, but=None):
        for vehicle in {0, 1} - {but}:
            self.relay.hear_state(vehicle, state(self.ticks.tick))
            self.relay.hear_packets(vehicle, self.ticks.tick, [])


def test_real_time_begins_once_every_state_is_known_and_then_by_the_clock(water):
    case = Case(water)
    relay = case.relay
    relay.hear_state(0, state(0))
    relay.hear_packets(0, 0, [HELLO])
    assert not relay.advance()
    assert relay.owed() == [("vehicle_node", 1)]
    relay.hear_state(1, state(0))
    assert relay.advance()
    assert not relay.advance()
    case.ticks.tick = 4
    assert (relay.advance(), relay.tick) == (True, 4)
    assert water.take() == [("tick", 0, [0, 0]), ("tick", 4, [0, 0])]


def test_real_time_sends_at_once_unless_the_position_of_the_modem_is_old(water):
    case = Case(water)
    case.all_answer()
    case.relay.advance()
    water.take()
    case.ticks.tick = 5
    case.relay.hear_packets(1, 5, [HELLO])
    assert water.take() == [("transmit", 1, [0, 0])]
    case.ticks.tick = 6
    case.relay.hear_packets(1, 6, [HELLO])
    assert (water.take(), case.watch.packets_unsent) == ([], 1)


def test_real_time_goes_on_without_a_silent_vehicle_and_its_hull_drifts(water):
    case = Case(water)
    case.all_answer()
    case.relay.advance()
    case.ticks.tick = 31
    case.all_answer(but=1)
    assert case.relay.owed() == [("agent_node", 1), ("vehicle_node", 1)]
    assert case.relay.drop() == case.relay.lost == [1]
    assert case.relay.owed() == []
    case.relay.hear_state(1, state(31, north_m=5.0))
    water.take()
    assert case.relay.advance()
    assert water.take() == [("drift", 1, 1), ("tick", 31, [31, 1])]
