"""The verdict on a flight from its recording."""

import math

import pytest

from auv_bringup.launching.verdict import verdict
from auv_experiment.scenario.loading import load_scenario

SCENARIO = load_scenario("flock_acoustic")
FLOWN_S = SCENARIO.ticks * SCENARIO.period_s


@pytest.mark.parametrize(
    ("mode", "duration_s", "collision", "status"),
    [
        ("lockstep", FLOWN_S, False, 0),
        ("lockstep", math.nextafter(FLOWN_S, 0.0), False, 0),
        ("lockstep", FLOWN_S, True, 4),
        ("lockstep", FLOWN_S - SCENARIO.period_s, True, 3),
        ("realtime", FLOWN_S - SCENARIO.period_s, False, 0),
        ("inprocess", FLOWN_S, True, 4),
    ],
)
def test_the_status_follows_from_mode_length_and_touch(mode, duration_s, collision, status):
    found, why = verdict({"duration_s": duration_s, "collision": collision}, SCENARIO, mode)
    assert found == status
    assert bool(why) == bool(status)


def test_metrics_that_are_not_there_condemn_nobody():
    assert verdict({}, SCENARIO, "lockstep") == (0, "")
