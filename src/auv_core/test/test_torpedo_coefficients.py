"""Claims about the torpedo with published coefficients, and the LAUV."""

import math

import pytest
from torpedo_flights import STILL, angles_deg, lauv

from auv_core.models._spheroid import Spheroid
from auv_core.models.torpedo_coefficients import body_of


def rpm_of(thrust_n):
    params = lauv().params
    return params.servos.propeller_max_rpm * math.sqrt(thrust_n / params.thrust_max_n)


def settled(rudder_deg, thrust_n):
    start = lauv().initial_state((0.0, 0.0, 50.0), 0.0, 1.0)
    return lauv().step(start, (math.radians(rudder_deg), 0.0, rpm_of(thrust_n)), STILL, 0.05, 1200)


def test_added_mass_is_that_of_the_spheroid():
    shape = Spheroid(0.54, 0.075)
    assert shape.lamb_factors() == pytest.approx((0.03435, 0.93571, 0.81402), rel=1e-3)
    assert shape.added_mass(18.0, 0.0) == pytest.approx(
        (0.6183, 16.843, 16.843, 0.0, 0.8710, 0.8710), rel=1e-4
    )
    assert body_of(lauv().params).surge_kg == pytest.approx(18.6183, rel=1e-4)


@pytest.mark.parametrize(
    ("thrust_n", "speed_mps"), [(3.0, 0.7104), (5.0, 1.0157), (8.0, 1.3832), (14.0, 1.9588)]
)
def test_steady_speeds(thrust_n, speed_mps):
    state = settled(0.0, thrust_n)
    assert state[7] == pytest.approx(speed_mps, abs=0.002)
    assert angles_deg(state)[1] == pytest.approx(-5.0, abs=0.3), "it is 1 N light"


def test_turns():
    state = settled(15.0, 8.0)
    speed_mps = math.hypot(*state[7:10])
    assert speed_mps == pytest.approx(1.255, rel=0.02)
    assert math.degrees(state[12]) == pytest.approx(15.47, rel=0.02)
    assert speed_mps / state[12] == pytest.approx(4.65, rel=0.02)
    tight = settled(30.0, 8.0)
    assert math.hypot(*tight[7:10]) / tight[12] == pytest.approx(2.87, rel=0.02)


def test_without_its_drop_weight_it_rises():
    state = lauv().adrift().step(settled(0.0, 8.0), (0.0, 0.0, 0.0), STILL, 0.05, 2000)
    assert lauv().adrift().params.net_weight_n == -10.0
    assert state[9] < -0.1
    assert abs(state[15]) < 1e-9
