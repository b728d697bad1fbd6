"""Claim: orders and signs of actuators are those of docs/reference/conventions.md."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import auv_core.models
from auv_core.models import make_model, thrusters_of
from auv_core.params import load_section

PRESETS = Path(auv_core.models.__file__).parent / "presets"
STILL = (0.0, 0.0, 0.0)


def section(name):
    return load_section(yaml.safe_load((PRESETS / f"{name}.yaml").read_text()), "model", "auv_core.models")


@pytest.mark.parametrize("name", ["remus100", "lauv"])
def test_rudder_turns_to_starboard_planes_lower_the_nose_and_the_propeller_drives_ahead(name):
    model: Any = make_model(section(name))
    rpm = model.steady_rpm(1.0)

    def nu(*command):
        start = model.initial_state((0.0, 0.0, 30.0), 0.0, 1.0)
        return np.array(model.step(start, command, STILL, 0.05, 20)[7:13])

    straight = nu(0.0, 0.0, rpm)
    assert (nu(0.1, 0.0, rpm) - straight)[5] > 0.01
    assert (nu(0.0, 0.1, rpm) - straight)[4] < -0.01
    assert (nu(0.0, 0.0, 1.2 * rpm) - straight)[0] > 0.001
    assert [each.name for each in model.actuators] == ["rudder", "stern_plane", "propeller"]
    assert [each.unit for each in model.actuators] == ["rad", "rad", "rpm"]


@pytest.mark.parametrize(
    ("name", "order"),
    [
        ("odin", ["fore port", "aft port", "aft starboard", "fore starboard"]),
        ("bluerov2_heavy", ["fore starboard", "fore port", "aft starboard", "aft port"]),
    ],
)
def test_thrusters_have_their_order_and_the_vertical_ones_lift(name, order):
    read = yaml.safe_load((PRESETS / f"{name}.yaml").read_text())
    read["params"]["actuators"] = "thrusters"
    thrusters = thrusters_of(load_section(read, "model", "auv_core.models"))
    places = np.reshape(thrusters.positions_m, (-1, 3))
    words = [f"{'fore' if x > 0.0 else 'aft'} {'starboard' if y > 0.0 else 'port'}" for x, y, _ in places]
    assert words == 2 * order
    T = thrusters.matrix()
    assert not T[2, :4].any()
    assert T[2, 4:] == pytest.approx(-1.0)
