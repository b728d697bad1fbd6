"""Claims about the vehicles' own navigation."""

import math

import numpy as np
import pytest

from auv_core.messages import VehicleState
from auv_core.state_checks import checked_state
from auv_sim.navigation import exact, noisy
from auv_sim.vehicle import DivergedError, Vehicle, check_finite


def truth(tick):
    return VehicleState(tick, (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.1, 0.2, 0.3, 0.0, 0.0, 0.4))


def test_exact_navigation_is_the_truth():
    assert exact.Navigation(exact.Params(), 1, 1, 0.1).measured(truth(5)) == truth(5)


def test_noise_has_the_standard_deviations_asked_for_and_no_bias():
    params = noisy.Params(position_sd_m=0.05, velocity_sd_mps=0.01)
    navigation = noisy.Navigation(params, 1, 2, 0.1)
    measured = [navigation.measured(truth(tick)) for tick in range(4000)]
    errors_m = np.array([state.position for state in measured]) - truth(0).position
    errors_mps = np.array([state.nu[:3] for state in measured]) - truth(0).nu[:3]
    np.testing.assert_allclose(errors_m.std(axis=0), 0.05, rtol=0.05)
    np.testing.assert_allclose(errors_mps.std(axis=0), 0.01, rtol=0.05)
    assert np.abs(errors_m.mean(axis=0)).max() < 4.0 * 0.05 / math.sqrt(4000)
    assert all(state.nu[3:] == truth(0).nu[3:] and checked_state(state)[0] is state for state in measured)


def test_noise_belongs_to_seed_vehicle_and_tick():
    def at(seed, address, tick):
        return noisy.Navigation(noisy.Params(), seed, address, 0.1).measured(truth(tick)).position

    assert at(1, 1, 7) == at(1, 1, 7)
    assert len({at(1, 1, 7), at(2, 1, 7), at(1, 2, 7), at(1, 1, 8)}) == 4


def test_a_failed_measurement_is_marked_and_holds_the_last_one():
    navigation = noisy.Navigation(noisy.Params(failure_prob=0.3), 1, 1, 0.1)
    last, failures = None, 0
    for tick in range(500):
        state = navigation.measured(truth(tick))
        assert state.tick == tick
        if state.is_valid:
            last = state
        else:
            failures += 1
            assert last is None or state.position == last.position
    assert 100 < failures < 200


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_state_with_a_number_that_is_not_finite_is_not_usable(number):
    state = VehicleState(0, (0.0, number, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)
    assert checked_state(state)[0] is None
    with pytest.raises(DivergedError, match=r"auv_7: its motion has no finite solution after t = 2\.50 s"):
        check_finite((1.0, number), "auv_7", 2.5)


def test_a_vehicle_reports_its_measurement_beside_the_truth():
    from auv_core.models import kinematic
    from auv_core.params import Section
    from auv_sim.vehicle import VehicleConfig

    config = VehicleConfig(
        vehicle_id="auv_1",
        model=Section("kinematic", kinematic.Params()),
        position_ned_m=(0.0, 0.0, 5.0),
        navigation=Section("noisy", noisy.Params()),
    )
    vehicle = Vehicle(config)
    assert vehicle.nav.position != vehicle.state.position
    vehicle.step(None)
    assert vehicle.nav.tick == vehicle.state.tick == 1
    assert math.dist(vehicle.nav.position, vehicle.state.position) < 0.5
