"""Claims about a torpedo that is flown step by step, with fins commanded from outside."""

import math

import pytest

import shoal
from auv_core.messages import FinCommand
from auv_core.params import ConfigError


def test_fins_are_commanded_by_three_numbers_or_by_their_record():
    by_numbers, by_record = (shoal.Simulation("torpedo_steps") for _ in range(2))
    for _ in range(20):
        by_numbers.step({"auv_1": [0.2, 0.0, 900.0]})
        by_record.step({"auv_1": FinCommand(0.2, 0.0, 900.0)})
    state = by_numbers.states["auv_1"]
    assert state == by_record.states["auv_1"]
    assert state.nu[5] > 0.05, "it turns to starboard"
    command = by_numbers.commands["auv_1"]
    assert isinstance(command, FinCommand)
    assert command.rudder_rad == pytest.approx(0.0, abs=math.radians(15.0))


@pytest.mark.parametrize("given", [[0.0] * 6, [0.1, 0.2], [0.1, math.nan, 900.0], "full ahead"])
def test_other_numbers_are_refused(given):
    simulation = shoal.Simulation("torpedo_steps")
    with pytest.raises(ConfigError, match=r"^commands\.auv_1: .* is not allowed; allowed: 3 finite numbers"):
        simulation.step({"auv_1": given})


def test_the_result_has_the_actuators():
    simulation = shoal.Simulation("torpedo_steps", duration_s=1.0)
    while not simulation.is_done:
        simulation.step()
    outputs = simulation.result().to_xarray()["actuator_output"]
    assert outputs.shape == (11, 1, 3)
    assert outputs["actuator"].values.tolist() == ["rudder", "stern_plane", "propeller"]
