"""Claims about currents that vary: their statistics, and that time alone determines them."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml

import auv_core.models
from auv_core.messages import Wrench
from auv_core.params import Section, load_section
from auv_sim.currents import gauss_markov, make_current, steady
from auv_sim.vehicle import MODELS, Vehicle, VehicleConfig

ODIN = Path(auv_core.models.__file__).parent / "presets" / "odin.yaml"
MEAN = (0.08, -0.06, 0.01)
SEEDS = range(1500)


def _current(params, *, seed=1, address=1, period_s=0.2):
    return make_current(Section("gauss_markov", params), MEAN, seed, address, period_s)


def _velocities(params, ticks, **options):
    """Return the (seeds, ticks, 3) velocities of many seeds without their mean."""
    currents = [_current(params, seed=seed, **options) for seed in SEEDS]
    return np.array([[current.at(tick) for tick in ticks] for current in currents]) - MEAN


@pytest.mark.parametrize("common_share", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(("period_s", "ticks"), [(1.0, (0, 10, 30)), (5.0, (0, 2, 6))])
def test_variance_and_correlation_do_not_depend_on_the_period(common_share, period_s, ticks):
    params = gauss_markov.Params(sd_ned_mps=(0.1, 0.05, 0.0), memory_s=20.0, common_share=common_share)
    found = _velocities(params, ticks, period_s=period_s)
    assert found.std(axis=0)[:, 0] == pytest.approx(0.1, rel=0.06)
    assert found.std(axis=0)[:, 1] == pytest.approx(0.05, rel=0.06)
    assert np.abs(found[..., 2]).max() < 1e-15
    assert np.abs(found.mean(axis=0)).max() < 0.01
    for later in (1, 2):
        expected = math.exp(-ticks[later] * period_s / 20.0)
        for axis in (0, 1):
            correlation = np.corrcoef(found[:, 0, axis], found[:, later, axis])[0, 1]
            assert correlation == pytest.approx(expected, abs=0.06)
    assert abs(np.corrcoef(found[:, 0, 0], found[:, 0, 1])[0, 1]) < 0.08


@pytest.mark.parametrize("common_share", [0.0, 0.3, 1.0])
def test_vehicles_share_as_much_of_the_current_as_stated(common_share):
    params = gauss_markov.Params(common_share=common_share)
    first, second = (_velocities(params, (7,), address=address)[:, 0, 0] for address in (1, 2))
    assert np.corrcoef(first, second)[0, 1] == pytest.approx(common_share, abs=0.07)
    assert np.array_equal(first, second) == (common_share == 1.0)


def test_the_current_seldom_differs_by_more_than_stated():
    params = gauss_markov.Params(sd_ned_mps=(0.1, 0.05, 0.02))
    away_mps = np.linalg.norm(_velocities(params, (0, 40)), axis=-1)
    assert _current(params).varies_by_mps == pytest.approx(3.0 * math.hypot(0.1, 0.05, 0.02))
    assert (away_mps > _current(params).varies_by_mps).mean() < 0.01


def test_a_steady_current_is_its_mean():
    current = make_current(Section("steady", steady.Params()), MEAN, 1, 1, 0.2)
    assert {current.at(tick) for tick in range(5)} == {MEAN}
    assert current.varies_by_mps == 0.0


def _vehicle(current):
    return Vehicle(
        VehicleConfig(
            vehicle_id="auv_1",
            model=load_section(yaml.safe_load(ODIN.read_text(encoding="utf-8")), "model", MODELS),
            position_ned_m=(0.0, 0.0, 10.0),
            current_ned_mps=MEAN,
            current=current,
            dt_s=0.1,
            period_s=0.1,
            seed=4,
        )
    )


def test_a_vehicle_drifts_with_the_water_about_its_mean():
    varying = Section("gauss_markov", gauss_markov.Params(sd_ned_mps=(0.3, 0.3, 0.0), memory_s=5.0))
    still, moved = _vehicle(Section("steady", steady.Params())), _vehicle(varying)
    for _ in range(300):
        still.step(None)
        moved.step(None)
    assert math.dist(still.state.position[:2], moved.state.position[:2]) > 0.1


def test_a_vehicle_restored_at_a_tick_goes_on_in_the_same_water():
    section = Section("gauss_markov", gauss_markov.Params())
    whole, later = _vehicle(section), _vehicle(section)
    command = Wrench((20.0, 5.0, 0.0, 0.0, 0.0, 0.0))
    for _ in range(150):
        whole.step(command)
    later.restore(whole.state)
    for _ in range(20):
        assert later.step(command) == whole.step(command)
