"""The compiled loop flies a flock as the agents' own laws do, evaluated vehicle by vehicle."""

import os
import subprocess
import sys

import numpy as np
import pytest

from auv_core import compiled
from auv_core.pairs import near_pairs
from auv_core.params import ConfigError
from auv_experiment.inprocess import continuous, fleet_loop
from auv_experiment.inprocess import fleet as continuous_fleet
from auv_experiment.inprocess.hull_lanes import from_lanes, to_lanes
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario
from auv_flocking.separation import mathematical
from auv_sim.vehicle import DivergedError

_Mathematical = mathematical.Separation

_ARRAYS = (
    "position_ned_m",
    "attitude_quat_wxyz",
    "velocity_body",
    "command",
    "centre_ned_m",
    "centre_velocity_ned_mps",
    "reference_velocity_ned_mps",
)
_OBSTACLE = "environment.obstacles=[{position_ned_m: [2.0, 14.0, 38.0], safety_distance_m: 3.0}]"


@pytest.fixture(autouse=True)
def compiler(monkeypatch):
    monkeypatch.setattr(compiled, "_is_on", False)


def _flown(scenario, *, is_compiled):
    if is_compiled:
        compiled.use_compiler()
    assert compiled.is_compiling() == is_compiled
    recording = continuous.run_continuous(scenario)
    compiled._is_on = False
    return recording


def _largest_difference(one, other):
    differences = [0.0]
    for name in _ARRAYS:
        a, b = getattr(one, name), getattr(other, name)
        assert np.array_equal(np.isnan(a), np.isnan(b)), name
        differences.append(float(np.nanmax(np.abs(a - b), initial=0.0)))
    return max(differences)


@pytest.mark.parametrize(
    ("name", "duration_s", "overrides"),
    [
        ("ch5_obstacles", 5.0, ()),
        ("ch5_one_leader_blind", 5.0, ("agent.flocking.params.correction_limit_mps=0.5",)),
        ("ch6_obstacles", 1.0, ()),
        ("swarm", 1.0, ("vehicles.count=5", "environment.current_ned_mps=[0.1, -0.05, 0.0]", _OBSTACLE)),
        ("swarm", 1.0, ("vehicles.count=3", "agent.controller.params.max_force_n=20.0", "leaders=[auv_2]")),
        ("swarm", 0.4, ("vehicles.count=36", "agent.consensus.params.reach_m=9.0")),
    ],
)
def test_the_compiled_loop_gives_the_numbers_of_the_laws_themselves(name, duration_s, overrides):
    scenario = load_scenario(name, duration_s=duration_s, overrides=overrides)
    assert continuous_fleet.has_compiled_form(scenario)
    plain, fast = (_flown(scenario, is_compiled=is_compiled) for is_compiled in (False, True))
    assert _largest_difference(plain, fast) < 1e-12


def test_compiled_and_plain_are_one_source():
    """The same loop without the compiler, to the last bit."""
    scenario = load_scenario("swarm", duration_s=0.1, overrides=("vehicles.count=3",))
    recordings = []
    for is_compiled in (False, True):
        if is_compiled:
            compiled.use_compiler()
        recording = Recording.empty(["a", "b", "c"], scenario.tick_times(), has_neighbours=False)
        continuous_fleet.fly_fleet(scenario, recording, None)
        recordings.append(recording)
    assert _largest_difference(*recordings) == 0.0


def test_a_list_of_near_pairs_changes_no_number(monkeypatch):
    """
    A flock that contracts by metres, so that the list is made again, compared with all pairs to the last bit.
    """
    overrides = ("vehicles.count=7", "agent.consensus.params.reach_m=6.0", "dt_s=0.1",
                 "agent.flocking.params.path_gain_ps=0.2", "random_starts.radius_m=9.0")  # fmt: skip
    scenario = load_scenario("swarm", duration_s=8.0, overrides=overrides)
    all_pairs = _flown(scenario, is_compiled=True)
    lists = []
    monkeypatch.setattr(fleet_loop, "FEW", 2)

    def noted(points, reach_m):
        lists.append(points)
        return near_pairs(points, reach_m)

    monkeypatch.setattr(continuous_fleet, "near_pairs", noted)
    listed = Recording.empty(all_pairs.vehicle_ids, scenario.tick_times(), has_neighbours=False)
    continuous_fleet.fly_fleet(scenario, listed, None)
    assert len(lists) > 2
    assert _largest_difference(listed, all_pairs) == 0.0


_PROGRAM = """
import sys
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario
scenario = load_scenario("swarm", duration_s=0.2, overrides=["vehicles.count=3"])
run_in_process(scenario).save(sys.argv[1])
"""


def test_without_the_compiler_a_run_is_the_same(tmp_path):
    for name, disabled in (("compiled", "0"), ("plain", "1")):
        env = {**os.environ, "NUMBA_DISABLE_JIT": disabled, "PYTHONPATH": os.pathsep.join(sys.path)}
        path = tmp_path / f"{name}.npz"
        subprocess.run([sys.executable, "-c", _PROGRAM, str(path)], env=env, check=True, timeout=200)
    fast, plain = (Recording.load(tmp_path / f"{name}.npz") for name in ("compiled", "plain"))
    assert _largest_difference(fast, plain) < 1e-12


class _NotCentral:
    """The law of `mathematical` with nothing but its velocity."""

    def __init__(self, params):
        self.velocity = _Mathematical(params).velocity


def test_laws_that_the_loop_does_not_know_fly_as_they_are(monkeypatch):
    scenario = load_scenario("ch5_one_leader", duration_s=1.0)
    fast = _flown(scenario, is_compiled=True)
    monkeypatch.setattr(mathematical, "Separation", _NotCentral)
    assert not continuous_fleet.has_compiled_form(scenario)
    assert _largest_difference(fast, _flown(scenario, is_compiled=True)) < 1e-12


def test_a_motion_without_a_solution_names_its_vehicle():
    scenario = load_scenario("swarm", duration_s=20.0, overrides=("dt_s=0.1", "vehicles.count=2"))
    stiff = load_scenario(
        "swarm",
        duration_s=20.0,
        overrides=("dt_s=0.1", "vehicles.count=2", "agent.controller.params.velocity_gain_nspm=1.0e+7",
                   "agent.controller.params.max_force_n=1.0e+12", "vehicles.model.params.max_wrench=null"),
    )  # fmt: skip
    assert np.isfinite(_flown(scenario, is_compiled=True).position_ned_m).all()
    for is_compiled in (False, True):
        with pytest.raises(DivergedError, match=r"auv_[12]: its motion has no finite solution after t = "):
            _flown(stiff, is_compiled=is_compiled)
        compiled._is_on = False


def test_hulls_come_back_from_their_lanes():
    states = np.random.default_rng(3).normal(size=(19, 16))
    lanes = to_lanes([tuple(state) for state in states])
    assert lanes.shape == (2, 256)
    assert np.array_equal(from_lanes(lanes, 19), states)
    assert np.array_equal(from_lanes(np.stack([lanes, lanes]), 19)[1], states)


def test_a_fleet_is_so_many_vehicles_alike():
    scenario = load_scenario("swarm", overrides=("vehicles.count=3",))
    assert [vehicle.id for vehicle in scenario.vehicles] == ["auv_1", "auv_2", "auv_3"]
    assert scenario.leaders == ("auv_1", "auv_2", "auv_3")
    assert len({vehicle.model for vehicle in scenario.vehicles}) == 1


@pytest.mark.parametrize("count", ["0", "255", "2.5", "true", "many"])
def test_a_count_that_is_none_is_refused(count):
    with pytest.raises(
        ConfigError, match=r"^scenario\.vehicles\.count: .* is not allowed; allowed: a whole number"
    ):
        load_scenario("swarm", overrides=(f"vehicles.count={count}",))


def test_a_reach_keeps_estimates_apart():
    """Two pairs, farther apart than the reach: each pair agrees on its own centre."""
    overrides = ("agent.consensus.params.reach_m=5.0", "vehicles.0.position_ned_m=[0.0, 0.0, 10.0]",
                 "vehicles.1.position_ned_m=[4.0, 0.0, 10.0]", "vehicles.2.position_ned_m=[50.0, 0.0, 10.0]",
                 "vehicles.3.position_ned_m=[54.0, 0.0, 10.0]", "agent.flocking.params.cohesion_gain_ps=0.0",
                 "agent.flocking.params.path_gain_ps=0.0", "leaders=[]")  # fmt: skip
    recording = _flown(
        load_scenario("ch5_one_leader", duration_s=10.0, overrides=overrides), is_compiled=True
    )
    north_m = recording.centre_ned_m[-1, :, 0]
    # Two that hear each other: c = own + (other - own) / 3.
    assert north_m == pytest.approx([4.0 / 3.0, 8.0 / 3.0, 50.0 + 4.0 / 3.0, 50.0 + 8.0 / 3.0], abs=1e-6)
