"""Claims about whole flights with each estimator: the choice decides nothing but the computing time."""

import numpy as np
import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario


def _flown(kind, duration_s, *overrides):
    scenario = load_scenario(
        "flock_modem",
        overrides=[f"agent.neighbours.estimator.kind={kind}", "acoustics.mac.params.slot_s=0.5", *overrides],
        seed=5001,
        duration_s=duration_s,
    )
    return run_in_process(scenario)


def _assert_equal(one, other):
    for name in ("position_ned_m", "neighbour_position_ned_m", "neighbour_covariance"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("kind", ["filterpy_ekf", "filterpy_ukf"])
def test_a_flock_flies_the_same_with_filterpys_filters(kind):
    _assert_equal(_flown("ekf", 60.0), _flown(kind, 60.0))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["filterpy_ekf", "filterpy_ukf"])
def test_a_flock_flies_the_same_for_650_s(kind):
    _assert_equal(_flown("ekf", 650.0), _flown(kind, 650.0))


@pytest.mark.slow
def test_with_sonar_and_drift_it_is_filterpys_too():
    changes = ("environment.navigation={kind: dead_reckoning}", "acoustics.sonar={kind: active}")
    _assert_equal(_flown("ekf", 100.0, *changes), _flown("filterpy_ekf", 100.0, *changes))
