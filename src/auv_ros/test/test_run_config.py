"""Claims about ticks and stamps."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.params import ConfigError, load
from auv_ros.run_config import (
    AGENT_PHASE,
    LOCKSTEP_EPOCH_S,
    RELAY_PHASE,
    START_LEAD_S,
    VEHICLE_PHASE,
    RunConfig,
    TickClock,
    WallWatch,
)


class Clocks:
    """A steady clock and a wall clock that a test moves."""

    def __init__(self, wall_s=1000.0):
        self.steady_s, self.wall_s = 50.0, wall_s

    def pass_time(self, dt_s):
        self.steady_s += dt_s
        self.wall_s += dt_s


def _clock(mode, clocks=None, *, period_s=0.1, epoch_s=0.0):
    clocks = clocks or Clocks()
    run = RunConfig(mode=mode, epoch_s=epoch_s)
    return TickClock(run, period_s, lambda: clocks.steady_s, lambda: clocks.wall_s)


@settings(max_examples=80, deadline=None)
@given(
    st.integers(0, 10**7),
    st.sampled_from([0.01, 0.02, 0.05, 0.1, 0.25, 0.3, 1.0]),
    st.sampled_from([1.0, 1.7e9]),
)
def test_tick_survives_its_stamp(tick, period_s, epoch_s):
    clock = _clock("realtime", period_s=period_s, epoch_s=epoch_s)
    assert clock.tick_of_stamp(clock.stamp_s(tick)) == tick


def test_lockstep_stamps_begin_at_the_fixed_epoch_whatever_the_wall_says():
    clock = _clock("lockstep", epoch_s=5.0)
    assert clock.stamp_s(0) == LOCKSTEP_EPOCH_S > 0.0
    assert clock.stamp_s(7) == LOCKSTEP_EPOCH_S + clock.scenario_s(7)


def test_lockstep_knows_its_start_and_a_given_epoch_is_the_start():
    assert _clock("lockstep").started
    assert _clock("realtime", epoch_s=50.0).started
    assert _clock("realtime", epoch_s=50.0).stamp_s(10) == pytest.approx(51.0)


def test_realtime_without_an_epoch_begins_when_it_is_started():
    clock = _clock("realtime")
    assert not clock.started
    assert clock.stamp_s(10) == 0.0
    clock.begin()
    assert clock.started
    assert clock.stamp_s(10) == pytest.approx(1001.0 + START_LEAD_S)
    assert clock.tick_now() == -5


def test_who_joins_a_run_has_its_stamps_and_its_ticks():
    clocks = Clocks()
    first, late = _clock("realtime", clocks), _clock("realtime", clocks)
    first.begin()
    clocks.pass_time(12.04 + START_LEAD_S)
    late.join(first.epoch_s + 1e-7)
    assert [late.stamp_s(tick) for tick in range(50)] == [first.stamp_s(tick) for tick in range(50)]
    assert late.tick_now() == first.tick_now() == 120


@pytest.mark.parametrize("step_s", [-3600.0, -20.0, 20.0, 3600.0])
def test_a_step_of_the_wall_clock_moves_no_tick_and_no_stamp(step_s):
    clocks = Clocks()
    clock, given = _clock("realtime", clocks), _clock("realtime", clocks, epoch_s=1000.0)
    clock.begin()
    clocks.pass_time(5.0)
    before = clock.tick_now(), given.tick_now(), clock.stamp_s(3)
    clocks.wall_s += step_s
    assert (clock.tick_now(), given.tick_now(), clock.stamp_s(3)) == before


@pytest.mark.parametrize("step_s", [-3600.0, 20.0])
def test_who_joins_after_a_step_follows_the_clock_of_the_run(step_s):
    clocks = Clocks()
    first, late = _clock("realtime", clocks), _clock("realtime", clocks)
    first.begin()
    clocks.pass_time(8.0 + START_LEAD_S)
    clocks.wall_s += step_s
    late.join(first.epoch_s, step_s)
    clocks.pass_time(0.05)
    assert late.tick_now() == first.tick_now() == 80


@pytest.mark.parametrize("phase", [VEHICLE_PHASE, RELAY_PHASE, AGENT_PHASE])
def test_a_phase_of_a_tick_is_that_far_behind_its_stamp(phase):
    clocks = Clocks()
    clock = _clock("realtime", clocks)
    clock.begin()
    for dt_s in (0.0, 0.013, 0.77, 5.004):
        clocks.pass_time(dt_s)
        wait_s = clock.until_phase_s(phase)
        assert 0.0 <= wait_s < 0.1
        before = clock.tick_now()
        clocks.pass_time(wait_s + 1e-6)
        assert clock.tick_now() in (before, before + 1)
        in_tick_s = clocks.wall_s - clock.stamp_s(clock.tick_now())
        assert in_tick_s == pytest.approx(0.1 * phase, abs=2e-6)


def test_an_epoch_once_set_stays():
    clock = _clock("realtime", epoch_s=50.0)
    clock.join(200.0)
    clock.begin()
    assert clock.epoch_s == 50.0


def test_a_step_of_the_wall_clock_is_told_once_and_a_slow_drift_never():
    clocks = Clocks()
    watch = WallWatch(lambda: clocks.steady_s, lambda: clocks.wall_s)
    for _ in range(100):
        clocks.pass_time(1.0)
        clocks.wall_s += 0.01
        assert watch.warning() == ""
    clocks.wall_s -= 20.0
    assert watch.warning() == "the system clock was stepped by -20.0 s; the run goes on by the steady clock"
    assert watch.warning() == ""


@pytest.mark.parametrize(
    ("mode", "epoch_s", "waits"),
    [("lockstep", 0.0, True), ("lockstep", 5.0, True), ("realtime", 0.0, True), ("realtime", 5.0, False)],
)
def test_only_realtime_with_an_epoch_of_its_own_waits_for_nobody(mode, epoch_s, waits):
    assert RunConfig(mode=mode, epoch_s=epoch_s).waits is waits


def test_tick_now_counts_whole_periods_and_is_negative_before_the_epoch():
    assert _clock("realtime", epoch_s=999.75).tick_now() == 2
    assert _clock("realtime", epoch_s=1000.5).tick_now() == -5


def test_unknown_mode_is_refused():
    with pytest.raises(ConfigError, match=r"^run\.mode: 'fast' is not allowed; allowed: lockstep, realtime"):
        load(RunConfig, {"mode": "fast"}, "run")
