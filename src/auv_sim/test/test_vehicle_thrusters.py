"""Claims about the simulated vehicle with thrusters: their outputs, and a fault."""

import math
from pathlib import Path

import pytest
import yaml

import auv_core.models
from auv_core.messages import ThrusterCommand, Wrench
from auv_core.models import thrusters_of
from auv_core.params import load_section
from auv_core.thrusters import ThrusterFault
from auv_sim.vehicle import MODELS, Vehicle, VehicleConfig

AHEAD = ThrusterCommand((40.0, -40.0, -40.0, 40.0, 0.0, 0.0, 0.0, 0.0))


def _vehicle(actuators="thrusters", **changes):
    path = Path(str(auv_core.models.__file__)).parent / "presets/odin.yaml"
    raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    raw["params"]["actuators"] = actuators
    model = load_section(raw, "model", MODELS)
    return Vehicle(VehicleConfig(vehicle_id="auv_1", model=model, position_ned_m=(1.0, 2.0, 3.0), **changes))


def test_it_takes_one_force_for_each_thruster_and_tells_their_outputs():
    vehicle = _vehicle()
    assert (vehicle.command, vehicle.command_size, len(vehicle.actuators)) == ("thrusters", 8, 8)
    vehicle.step(AHEAD)
    share = -math.expm1(-0.1 / 0.2)
    assert vehicle.actuator_outputs == pytest.approx([share * force for force in AHEAD.forces_n])


def test_the_hull_moves_as_under_the_wrench_of_the_forces_once_these_are_there():
    driven, pushed = _vehicle(), _vehicle("wrench")
    surge_n = 4.0 * 40.0 * math.sqrt(0.5)
    for _ in range(300):
        moved = driven.step(AHEAD)
        expected = pushed.step(Wrench((surge_n, 0.0, 0.0, 0.0, 0.0, 0.0)))
    assert moved.nu == pytest.approx(expected.nu, abs=2e-3)
    assert expected.nu[0] > 1.0


def test_without_a_command_the_forces_fade_and_the_hull_drifts():
    vehicle = _vehicle()
    for _ in range(20):
        vehicle.step(AHEAD)
    for _ in range(50):
        vehicle.step(None)
    assert vehicle.actuator_outputs == pytest.approx((0.0,) * 8, abs=1e-8)


def test_a_failed_thruster_gives_no_force_from_its_time_on():
    vehicle = _vehicle(fault=ThrusterFault(thruster=2, t_s=1.0))
    intact = _vehicle()
    for tick in range(60):
        state = vehicle.step(AHEAD)
        whole = intact.step(AHEAD)
        if tick < 10:
            assert state == whole
            assert vehicle.actuator_outputs == intact.actuator_outputs
    assert vehicle.actuator_outputs[1] == pytest.approx(0.0, abs=1e-8)
    others = [force for k, force in enumerate(vehicle.actuator_outputs) if k != 1]
    assert others == [force for k, force in enumerate(intact.actuator_outputs) if k != 1]


def test_a_restored_vehicle_has_forces_of_zero():
    vehicle = _vehicle()
    state = vehicle.step(AHEAD)
    vehicle.restore(state)
    assert vehicle.actuator_outputs == (0.0,) * 8


def test_only_a_vehicle_that_is_flown_with_thrusters_has_them():
    path = Path(str(auv_core.models.__file__)).parent / "presets/odin.yaml"
    raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert thrusters_of(load_section(raw, "model", MODELS)).count == 0
