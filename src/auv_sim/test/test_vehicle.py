"""Claims about the simulated vehicle: substeps, actuators, current."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_core.geometry import body_to_ned
from auv_core.messages import FinCommand, VehicleState, VelocityCommand, Wrench
from auv_core.models.six_dof import Model
from auv_core.params import ConfigError, load, load_section
from auv_sim.vehicle import MODELS, Vehicle, VehicleConfig, substeps

PRESETS = Path(auv_core.models.__file__).parent / "presets"


def _model(preset):
    return load_section(yaml.safe_load((PRESETS / f"{preset}.yaml").read_text()), "model", MODELS)


def _config(preset="odin", **changes):
    values = {
        "vehicle_id": "auv_1",
        "model": _model(preset),
        "position_ned_m": (1.0, 2.0, 3.0),
        "heading_rad": 0.5,
    }
    return VehicleConfig(**{**values, **changes})


def _numbers(state):
    return (*state.position, *state.attitude, *state.nu)


@settings(max_examples=80, deadline=None)
@given(st.integers(1, 1000), st.sampled_from([0.001, 0.01, 0.02, 0.05, 0.1]))
def test_a_period_of_n_steps_has_n_substeps(count, dt_s):
    assert substeps(count * dt_s, dt_s) == count


@pytest.mark.parametrize(
    ("period_s", "dt_s"), [(0.1, 0.03), (0.1, 0.2), (0.1, 0.0999), (0.1, 1e-8), (0.1, 1e-320)]
)
def test_a_period_that_the_step_does_not_divide_is_refused(period_s, dt_s):
    with pytest.raises(
        ValueError, match=r"^period_s: 0\.1 is not allowed; allowed: a whole multiple of dt_s"
    ):
        substeps(period_s, dt_s)


def test_the_config_refuses_such_a_period_with_its_path():
    raw = {
        "vehicle_id": "a",
        "model": {"kind": "kinematic"},
        "position_ned_m": [0, 0, 0],
        "dt_s": 0.03,
        "period_s": 0.1,
    }
    with pytest.raises(ConfigError, match=r"^vehicle\.period_s: 0\.1 is not allowed"):
        load(VehicleConfig, raw, "vehicle")


def test_a_period_is_so_many_steps_of_the_model_with_the_command_held():
    config = _config(current_ned_mps=(0.1, -0.2, 0.0))
    vehicle, model = Vehicle(config), Model(config.model.params)
    wrench = (20.0, -5.0, 3.0, 0.5, 0.2, -1.0)
    state = model.initial_state(config.position_ned_m, config.heading_rad)
    for tick in range(1, 4):
        for _ in range(5):
            state = model.step(state, wrench, config.current_ned_mps, 0.02)
        after = vehicle.step(Wrench(wrench))
        assert after.tick == tick
        assert _numbers(after) == state


def test_actuators_clip_what_is_asked():
    weak, strong = Vehicle(_config()), Vehicle(_config())
    limit = _model("odin").params.max_wrench
    for _ in range(5):
        asked = weak.step(Wrench((1e6, -1e6, 1e6, -1e6, 1e6, -1e6)))
        held = strong.step(
            Wrench(tuple(sign * x for sign, x in zip((1, -1, 1, -1, 1, -1), limit, strict=True)))
        )
    assert asked == held


def test_without_a_command_the_hull_drifts_towards_the_waters_velocity():
    current = (0.2, 0.1, 0.0)
    vehicle = Vehicle(_config(current_ned_mps=current))
    speeds = []
    for _ in range(300):
        state = vehicle.step(None)
        speeds.append(body_to_ned(state.attitude, state.nu[:3])[0])
    assert speeds == sorted(speeds), "it only ever speeds up"
    assert 0.1 < speeds[-1] < current[0]
    assert vehicle.step(None) == vehicle.state


def test_a_kinematic_vehicle_moves_as_commanded_and_stands_without_a_command():
    vehicle = Vehicle(_config("point"))
    assert vehicle.command == "velocity"
    for _ in range(10):
        state = vehicle.step(VelocityCommand((0.1, 0.0, -0.2), 0.0))
    assert state.position == pytest.approx((1.1, 2.0, 2.8))
    assert vehicle.step(None).position == state.position


def test_a_restored_vehicle_goes_on_as_the_original():
    original, copy = Vehicle(_config()), Vehicle(_config(position_ned_m=(9.0, 9.0, 9.0)))
    for _ in range(7):
        original.step(Wrench((10.0, 5.0, 0.0, 0.0, 0.0, 2.0)))
    copy.restore(original.state)
    command = Wrench((-3.0, 2.0, 1.0, 0.0, 0.0, 0.0))
    assert copy.step(command) == original.step(command)
    assert copy.state.tick == 8


def test_the_first_state_is_level_and_at_rest_at_tick_zero():
    state = Vehicle(_config()).state
    assert isinstance(state, VehicleState)
    assert (state.tick, state.position, state.nu) == (0, (1.0, 2.0, 3.0), (0.0,) * 6)
    assert state.attitude[1:3] == (0.0, 0.0)


def test_after_its_computer_has_failed_a_vehicle_obeys_no_command():
    failing, resting = Vehicle(_config(fails_at_s=0.3)), Vehicle(_config())
    for tick in range(6):
        pushed = failing.step(Wrench((50.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
        drifting = resting.step(Wrench((50.0, 0.0, 0.0, 0.0, 0.0, 0.0)) if tick < 3 else None)
        assert pushed == drifting


def test_a_torpedo_takes_fins_and_its_actuators_have_outputs():
    vehicle = Vehicle(_config("remus100", speed_mps=1.5))
    assert (vehicle.command, vehicle.command_size) == ("fins", 3)
    assert [each.name for each in vehicle.actuators] == ["rudder", "stern_plane", "propeller"]
    assert vehicle.state.nu[0] == 1.5
    assert vehicle.actuator_outputs[2] == pytest.approx(896.2, abs=0.1)
    for _ in range(30):
        state = vehicle.step(FinCommand(0.1, 0.0, 900.0))
    assert vehicle.actuator_outputs[0] == pytest.approx(0.1, abs=1e-6)
    assert state.nu[5] > 0.03


def test_a_torpedo_without_its_computer_drops_its_weight_and_rises():
    failing = Vehicle(_config("remus100", speed_mps=1.5, position_ned_m=(0.0, 0.0, 30.0), fails_at_s=0.0))
    for _ in range(600):
        state = failing.step(FinCommand(0.2, 0.2, 1500.0))
    assert state.position[2] == pytest.approx(17.6, abs=0.3)
    assert failing.actuator_outputs == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_a_restored_torpedo_has_its_actuators_at_rest():
    vehicle = Vehicle(_config("remus100", speed_mps=1.5))
    vehicle.restore(vehicle.state)
    assert vehicle.actuator_outputs == (0.0, 0.0, 0.0)
