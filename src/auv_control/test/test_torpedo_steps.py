"""
Claims about the autopilots on the torpedo: a turn of 30 degrees and a dive of 10 m, commanded at once.

The headings, depths and pitch were computed with Fossen's published program of the vehicle under the same
autopilots, and with a prototype of these equations.
"""

import math
from pathlib import Path

import pytest
import yaml
from torpedo_flights import STILL, angles_deg, lauv, remus

from auv_control.controllers import presets
from auv_control.guidance.autopilots import Params, Setpoint, initial_state, measured, piloted
from auv_core.messages import VehicleState
from auv_core.params import load_section

PERIOD_S = 0.1
STEP_AT_S = 10.0
GAINS = Params().gains


def state_of(x):
    return VehicleState(0, x[:3], x[3:7], x[7:13])


def steps_flown(model, times_s, *, gains=GAINS, speed_mps=1.5, turn_deg=30.0, dive_m=10.0):
    """Return heading (deg), depth (m) and pitch (deg) at some times (s)."""
    x = model.initial_state((0.0, 0.0, 10.0), 0.0, speed_mps)
    memory, flown = initial_state(10.0), {}
    for tick in range(round(max(times_s) / PERIOD_S) + 1):
        t_s = tick * PERIOD_S
        _, pitch_deg, heading_deg = angles_deg(x)
        flown[round(t_s, 6)] = (heading_deg, x[2], pitch_deg)
        is_late = t_s >= STEP_AT_S - 1e-9
        heading_rad = math.radians(turn_deg) if is_late else 0.0
        setpoint = Setpoint(heading_rad, 0.0, 10.0 + dive_m if is_late else 10.0, speed_mps)
        now = measured(state_of(x).numbers, x[7])
        command, memory = piloted(now, setpoint, memory, PERIOD_S, gains)
        x = model.step(x, model.limited_command(tuple(command)), STILL, 0.05, 2)
    return flown


@pytest.mark.parametrize(
    ("cross_flow", "headings_deg", "depths_m"),
    [
        ("horizontal", (8.98, 17.85, 24.22, 29.75, 30.90), (10.654, 12.883, 16.338, 19.617, 20.038)),
        ("both", (8.97, 17.77, 24.16, 29.75, 30.91), (10.605, 12.842, 16.342, 19.632, 20.021)),
    ],
)
def test_turn_and_dive(cross_flow, headings_deg, depths_m):
    flown = steps_flown(remus(cross_flow=cross_flow), (90.0,))
    assert [flown[t_s][0] for t_s in (12.0, 14.0, 16.0, 20.0, 30.0)] == pytest.approx(headings_deg, abs=0.1)
    assert [flown[t_s][1] for t_s in (14.0, 20.0, 30.0, 40.0, 60.0)] == pytest.approx(depths_m, abs=0.01)
    if cross_flow == "horizontal":
        assert flown[20.0][2] == pytest.approx(-15.49, abs=0.1)
    else:
        overshoot_deg = max(heading for heading, _, _ in flown.values()) - 30.0
        assert overshoot_deg == pytest.approx(0.99, abs=0.05)
        overshoot_m = max(depth for _, depth, _ in flown.values()) - 20.0
        assert overshoot_m == pytest.approx(0.53, abs=0.02)
        assert last_outside(flown, 0, 30.0, 1.0) == pytest.approx(9.0, abs=0.5)
        assert last_outside(flown, 1, 20.0, 0.2) == pytest.approx(40.2, abs=2.0)


def test_the_lauv_turns_and_dives_with_its_own_gains():
    raw = yaml.safe_load((Path(presets.__path__[0]) / "autopilot_lauv.yaml").read_text(encoding="utf-8"))
    gains = load_section(raw, "lauv", "auv_control.controllers").params.gains
    flown = steps_flown(lauv(), (90.0,), gains=gains, speed_mps=1.3)
    assert last_outside(flown, 0, 30.0, 1.0) < 8.0
    assert last_outside(flown, 1, 20.0, 0.2) < 60.0
    assert max(heading for heading, _, _ in flown.values()) < 31.0
    assert max(depth for _, depth, _ in flown.values()) < 20.5


def last_outside(flown, column, target, tolerance):
    """Return how long after the step a number was last farther from its target (s)."""
    return max(t_s for t_s, row in flown.items() if abs(row[column] - target) > tolerance) - STEP_AT_S
