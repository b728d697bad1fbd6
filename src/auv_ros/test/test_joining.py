"""Claim: a node that joins a run of real time acts at the run's ticks, whatever its wall clock shows."""

from itertools import chain, count

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from auv_ros.joining import JOIN_LIMIT_S, JOIN_S, LOOK_S, Joining
from auv_ros.run_config import RELAY_PHASE, START_LEAD_S

PERIOD_S = 0.1
LIMIT_S = JOIN_LIMIT_S + PERIOD_S


def statuses(*, stuck=False):
    """Give when the clock of a run speaks, and at which tick (s, scenario time)."""
    for k in count():
        now_s = LOOK_S * k - START_LEAD_S
        begun = 0 if stuck else max((now_s / PERIOD_S) - RELAY_PHASE, 0) // 1
        yield now_s, PERIOD_S * begun


def join(off_s, delays_s, *, from_s=-START_LEAD_S, stuck=False):
    """Join a run with a clock that is ahead; return by how much the ticks are, and when that was (s)."""
    joining = Joining(PERIOD_S)
    if from_s <= -START_LEAD_S:
        joining.wait()
    for (sent_s, time_s), delay_s in zip(statuses(stuck=stuck), delays_s, strict=False):
        if sent_s < from_s - 1e-9:
            continue
        now_s = sent_s + delay_s
        found_s = joining.hear(time_s, now_s + off_s, 70.0 + now_s)
        if found_s is not None:
            return off_s - found_s, now_s
    raise AssertionError("never joined")


def always(delay_s):
    return chain.from_iterable([delay_s] for _ in count())


@pytest.mark.parametrize("from_s", [-START_LEAD_S, 0.3, 3.5])
@pytest.mark.parametrize("off_s", [-3600.0, -4.0, -1.0, -0.3, 0.31, 1.0, 4.0, 3600.0])
def test_a_clock_that_is_off_is_not_followed(off_s, from_s):
    ahead_s, joined_s = join(off_s, always(0.01), from_s=from_s)
    assert -0.01 - PERIOD_S - 1e-9 <= ahead_s <= 1e-9
    assert joined_s <= from_s + JOIN_S + 2.0 * LOOK_S


@pytest.mark.parametrize("from_s", [-START_LEAD_S, -0.1, 0.3, 3.5])
@pytest.mark.parametrize("off_s", [-0.002, 0.0, 0.05])
def test_a_clock_that_fits_is_followed_at_once(off_s, from_s):
    ahead_s, joined_s = join(off_s, always(0.01), from_s=from_s)
    assert ahead_s == off_s
    assert joined_s <= from_s + LOOK_S + 0.02


def test_a_run_that_cannot_begin_without_us_is_joined():
    """Its clock says tick 0 until the relay knows where every vehicle is."""
    for off_s in (-4.0, -0.3, 0.31, 4.0):
        ahead_s, joined_s = join(off_s, always(0.01), stuck=True)
        assert -0.01 - 1e-9 <= ahead_s <= 1e-9
        assert joined_s < 1.0


def test_one_late_message_moves_nobody():
    for late_s in (0.4, 0.9, 3.0):
        assert join(0.0, chain([late_s], always(0.01)))[0] == 0.0


@settings(max_examples=300, deadline=None)
@example(off_s=-0.5, delays_s=[0.0] * 60, from_s=0.1)
@given(
    st.sampled_from([-4.0, -1.0, -0.3, -0.01, 0.0, 0.1, 0.3, 1.0, 4.0]) | st.floats(-10.0, 10.0),
    st.lists(st.floats(0.0, 0.19), min_size=60, max_size=60),
    st.sampled_from([-START_LEAD_S, -0.3, -0.1, 0.1, 2.0, 5.0]),
)
def test_ticks_are_off_by_no_more_than_the_limit_and_the_delay_of_messages(off_s, delays_s, from_s):
    ahead_s, _ = join(off_s, delays_s, from_s=from_s)
    unknown_s = START_LEAD_S if -START_LEAD_S < from_s < PERIOD_S + LOOK_S else 0.0
    assert -max(delays_s) - LOOK_S - unknown_s - 1e-9 <= ahead_s <= LIMIT_S + unknown_s + 1e-9
