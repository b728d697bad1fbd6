"""Claims about ticks and stamps."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.params import ConfigError, load
from auv_core.run_config import RunConfig, TickClock


def _clock(mode, *, period_s=0.1, epoch_s=0.0, now_s=lambda: 1000.0):
    return TickClock(RunConfig(mode=mode, epoch_s=epoch_s), period_s, now_s)


@settings(max_examples=80, deadline=None)
@given(
    st.integers(0, 10**7),
    st.sampled_from([0.01, 0.02, 0.05, 0.1, 0.25, 0.3, 1.0]),
    st.sampled_from([0.0, 1.7e9]),
)
def test_tick_survives_its_stamp(tick, period_s, epoch_s):
    clock = _clock("realtime", period_s=period_s, epoch_s=epoch_s)
    assert clock.tick_of_stamp(clock.stamp_s(tick)) == tick


def test_lockstep_stamps_are_scenario_time_whatever_the_wall_says():
    clock = _clock("lockstep", epoch_s=5.0)
    assert clock.stamp_s(7) == clock.scenario_s(7) == 7 * 0.1


def test_lockstep_knows_its_start_and_a_given_epoch_is_the_start():
    assert _clock("lockstep").started
    assert _clock("realtime", epoch_s=50.0).started
    assert _clock("realtime", epoch_s=50.0).stamp_s(10) == pytest.approx(51.0)


def test_realtime_without_an_epoch_begins_when_it_is_started():
    clock = _clock("realtime")
    assert not clock.started
    clock.start(200.0)
    assert clock.started
    assert clock.stamp_s(10) == pytest.approx(201.0)


def test_realtime_started_without_an_epoch_begins_now():
    clock = _clock("realtime", now_s=lambda: 1000.0)
    clock.start()
    assert clock.stamp_s(10) == pytest.approx(1001.0)


def test_an_epoch_once_set_stays():
    clock = _clock("realtime", epoch_s=50.0)
    clock.start(200.0)
    assert clock.epoch_s == 50.0


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
