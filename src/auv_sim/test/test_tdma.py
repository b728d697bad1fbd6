"""Claims about time-division multiple access."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_sim.acoustics.mac.tdma import Mac, Params

MODERATE = settings(max_examples=80, deadline=None)
FLEETS = st.integers(1, 12)
SLOTS_S = st.sampled_from([0.1, 0.25, 0.3, 0.5, 1.0, 2.0]) | st.floats(0.05, 3.0)
PERIODS_S = st.sampled_from([0.02, 0.05, 0.1, 0.25, 0.3, 1.0]) | st.floats(0.02, 2.0)
FIRST_TICKS = st.integers(0, 100_000)


def _opportunities(slot_s, fleet_size, period_s, ticks):
    """Return (start_s, address, tick) of all that may be sent, in the order of time."""
    mac = Mac(Params(slot_s=slot_s), fleet_size, 1)
    found = [
        (start_s, address, tick)
        for tick in ticks
        for address in range(1, fleet_size + 1)
        if (start_s := mac.opportunity_s(address, tick, period_s)) is not None
    ]
    return sorted(found)


@MODERATE
@given(FLEETS, SLOTS_S, PERIODS_S, FIRST_TICKS)
def test_no_two_transmissions_overlap(fleet_size, slot_s, period_s, first):
    found = _opportunities(slot_s, fleet_size, period_s, range(first, first + 60))
    for (before_s, *_), (after_s, *_) in pairwise(found):
        assert after_s - before_s >= slot_s * (1.0 - 1e-9) - 1e-9 * max(1.0, after_s * 1e-6)


@MODERATE
@given(FLEETS, SLOTS_S, PERIODS_S, FIRST_TICKS)
def test_every_slot_has_one_owner(fleet_size, slot_s, period_s, first):
    for start_s, address, _ in _opportunities(slot_s, fleet_size, period_s, range(first, first + 60)):
        slot = round(start_s / slot_s)
        assert start_s == pytest.approx(slot * slot_s, abs=1e-7)
        assert slot % fleet_size == address - 1


@MODERATE
@given(FLEETS, SLOTS_S, PERIODS_S, FIRST_TICKS)
def test_a_slot_is_offered_in_the_tick_in_which_it_begins(fleet_size, slot_s, period_s, first):
    for start_s, _, tick in _opportunities(slot_s, fleet_size, period_s, range(first, first + 60)):
        assert tick * period_s - 2e-9 <= start_s < (tick + 1) * period_s


@MODERATE
@given(FLEETS, SLOTS_S, PERIODS_S)
def test_no_slot_is_left_out_while_a_cycle_is_no_shorter_than_a_period(fleet_size, slot_s, period_s):
    period_s = min(period_s, slot_s * fleet_size)
    ticks = 80
    found = _opportunities(slot_s, fleet_size, period_s, range(ticks))
    slots = [round(start_s / slot_s) for start_s, *_ in found]
    assert slots == list(range(len(slots)))
    assert (slots[-1] + 1) * slot_s >= ticks * period_s - 1e-6


@pytest.mark.parametrize(
    ("slot_s", "period_s"), [(0.1, 0.1), (0.3, 0.1), (0.25, 0.05), (0.7, 0.1), (0.02, 0.02)]
)
def test_slots_that_begin_on_a_tick_belong_to_that_tick_at_every_hour(slot_s, period_s):
    mac = Mac(Params(slot_s=slot_s), 4, 1)
    ratio = round(slot_s / period_s)
    for cycle in [*range(50), 10_000, 123_456]:
        for address in range(1, 5):
            tick = (4 * cycle + address - 1) * ratio
            assert mac.opportunity_s(address, tick, period_s) == pytest.approx(tick * period_s)
            assert ratio == 1 or mac.opportunity_s(address, tick - 1, period_s) is None


def test_a_transmission_must_be_shorter_than_the_slot():
    mac = Mac(Params(slot_s=0.25), 4, 1)
    mac.check(0.2499)
    with pytest.raises(ValueError, match=r"^slot_s: 0\.25 is not allowed; allowed: longer than .* 0\.250 s"):
        mac.check(0.25)
