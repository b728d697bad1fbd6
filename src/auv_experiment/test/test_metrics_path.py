"""Path metrics and figures for motions with known results."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from auv_control.references import PathPoint
from auv_experiment.figures.files import save_figures
from auv_experiment.figures.path import path_drawers
from auv_experiment.metrics.path import (
    heading_rad,
    path_metrics,
    position_error_ned_m,
    velocity_error_ned_mps,
    velocity_ned_mps,
)
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Obstacle

DECAY_S, PERIOD_S = 5.0, 0.1
ROCK = Obstacle(position_ned_m=(6.0, 2.0, 0.0), safety_distance_m=1.0)


class _Line:
    """North at 0.1 m/s."""

    def at(self, t_s):
        return PathPoint((0.1 * t_s, 0.0, 0.0), (0.1, 0.0, 0.0))


def _scenario(*, n=1, obstacles=(), frame="body", paths=None):
    vehicle = SimpleNamespace(model=SimpleNamespace(params=SimpleNamespace(frame=frame)))
    return SimpleNamespace(
        name="line",
        vehicles=[vehicle] * n,
        period_s=PERIOD_S,
        kinematic=False,
        environment=SimpleNamespace(obstacles=obstacles),
        reference_of=lambda i: _Line() if paths is None or i in paths else None,
    )


def _decaying(n=1, heading=0.0, duration_s=100.0):
    """Vehicles that approach the line from 4 m behind it and 1, 2, 3 m east of it, with a force of 2 N."""
    ticks = round(duration_s / PERIOD_S)
    recording = Recording.empty([f"auv_{i + 1}" for i in range(n)], PERIOD_S * np.arange(ticks + 1))
    t_s = recording.t_s
    left = np.exp(-t_s / DECAY_S)
    c, s = math.cos(heading), math.sin(heading)
    recording.attitude_quat_wxyz[:] = (math.cos(heading / 2.0), 0.0, 0.0, math.sin(heading / 2.0))
    recording.command[:] = (2.0, 0.0, 0.0, 0.0, 0.0, 5.0)
    recording.velocity_body[:] = 0.0
    recording.position_ned_m[:] = 0.0
    for i in range(n):
        east = (i + 1.0) * left
        recording.position_ned_m[:, i, 0] = 0.1 * t_s - 4.0 * left
        recording.position_ned_m[:, i, 1] = east
        north_mps, east_mps = 0.1 + 4.0 * left / DECAY_S, -east / DECAY_S
        recording.velocity_body[:, i, 0] = c * north_mps + s * east_mps
        recording.velocity_body[:, i, 1] = c * east_mps - s * north_mps
    return recording


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
def test_errors_are_in_ned_whatever_the_heading(heading):
    recording = _decaying(heading=heading)
    left = np.exp(-recording.t_s / DECAY_S)
    error_m = position_error_ned_m(recording, _scenario())[:, 0]
    np.testing.assert_allclose(error_m, np.column_stack([4.0 * left, -left, 0.0 * left]), atol=1e-12)
    error_mps = velocity_error_ned_mps(recording, _scenario())[:, 0]
    np.testing.assert_allclose(error_mps, -error_m / DECAY_S, atol=1e-12)
    np.testing.assert_allclose(heading_rad(recording), heading, atol=1e-12)


def test_the_rates_of_a_flat_plant_are_those_of_the_position():
    recording = _decaying(heading=1.0)
    np.testing.assert_array_equal(
        velocity_ned_mps(recording, _scenario(frame="flat")), recording.velocity_body[..., :3]
    )


def test_numbers_of_a_known_decay():
    metrics = path_metrics(_decaying(heading=0.5), _scenario())
    size_m = math.hypot(4.0, 1.0)
    assert metrics["overshoot_x_m"] == pytest.approx(4.0)
    assert metrics["undershoot_y_m"] == pytest.approx(-1.0)
    assert metrics["velocity_err_x_peak_mps"] == pytest.approx(0.8)
    assert metrics["velocity_err_y_peak_mps"] == pytest.approx(0.2)
    assert metrics["x_settling_0p1m_s"] == pytest.approx(DECAY_S * math.log(40.0), abs=PERIOD_S)
    assert metrics["y_settling_0p2m_s"] == pytest.approx(DECAY_S * math.log(5.0), abs=PERIOD_S)
    assert metrics["y_settling_0p1m_s"] == pytest.approx(DECAY_S * math.log(10.0), abs=PERIOD_S)
    assert metrics["position_settling_0p1m_s"] == pytest.approx(
        DECAY_S * math.log(10.0 * size_m), abs=PERIOD_S
    )
    assert metrics["velocity_settling_0p01mps_s"] == pytest.approx(DECAY_S * math.log(80.0), abs=PERIOD_S)
    assert metrics["position_rms_m"] == pytest.approx(size_m * math.sqrt(DECAY_S / 2.0 / 100.0), rel=0.02)
    late_m = size_m * math.exp(-30.0 / DECAY_S)
    assert metrics["position_err_max_m"] == pytest.approx(late_m, rel=0.03)
    assert metrics["position_rms_after_30s_m"] == pytest.approx(
        late_m * math.sqrt(DECAY_S / 2.0 / 70.0), rel=0.02
    )
    assert metrics["control_effort_n2s"] == pytest.approx(4.0 * 100.0)
    assert "obstacle_clearance_m" not in metrics


def test_of_several_vehicles_the_worst_counts_and_effort_adds_up():
    metrics = path_metrics(_decaying(n=3), _scenario(n=3))
    assert metrics["undershoot_y_m"] == pytest.approx(-3.0)
    assert metrics["y_settling_0p1m_s"] == pytest.approx(DECAY_S * math.log(30.0), abs=PERIOD_S)
    assert metrics["control_effort_n2s"] == pytest.approx(3 * 4.0 * 100.0)
    one = path_metrics(_decaying(n=3), _scenario(n=3, paths={0}))
    assert one["undershoot_y_m"] == pytest.approx(-1.0)
    assert path_metrics(_decaying(), _scenario(paths=set())) == {}


def test_obstacles_are_measured_each_and_settling_ends_at_60_s():
    recording = _decaying()
    recording.position_ned_m[recording.t_s > 70.0, 0, 1] += 1.5
    metrics = path_metrics(recording, _scenario(obstacles=(ROCK, Obstacle(position_ned_m=(0.0, 3.0, 4.0)))))
    assert metrics["obstacle_clearance_m"][0] == pytest.approx(math.hypot(1.0, 0.5), abs=0.02)
    assert metrics["obstacle_closest_at_s"][0] == pytest.approx(70.1)
    assert metrics["obstacle_clearance_m"][1] == pytest.approx(
        np.linalg.norm(recording.position_ned_m[:, 0] - (0.0, 3.0, 4.0), axis=1).min()
    )
    assert metrics["y_settling_0p1m_s"] == pytest.approx(DECAY_S * math.log(10.0), abs=PERIOD_S)
    assert path_metrics(recording, _scenario())["y_settling_0p1m_s"] is None


def test_what_does_not_exist_is_none():
    metrics = path_metrics(_decaying(duration_s=2.0), _scenario())
    for key in ("position_rms_after_30s_m", "position_err_max_m", "x_settling_0p1m_s", "y_settling_0p2m_s"):
        assert metrics[key] is None
    assert metrics["overshoot_x_m"] == pytest.approx(4.0)


def test_a_lost_vehicle_leaves_the_errors():
    recording = _decaying(n=2)
    recording.lost_at_s[1] = 0.0
    metrics = path_metrics(recording, _scenario(n=2))
    assert metrics["undershoot_y_m"] == pytest.approx(-1.0)


@pytest.mark.parametrize(("n", "duration_s"), [(2, 100.0), pytest.param(1, 1.0, marks=pytest.mark.slow)])
@pytest.mark.filterwarnings("error")
def test_figures_are_drawn(tmp_path, n, duration_s):
    scenario = _scenario(n=n, obstacles=(ROCK,))
    drawers = path_drawers(_decaying(n, duration_s=duration_s), scenario)
    drawn = save_figures(drawers, scenario, tmp_path).figures
    assert [figure.path.stem for figure in drawn] == [
        "path_plan",
        "path_position_errors",
        "path_velocity_errors",
        "path_forces",
    ]
    assert all(figure.path.stat().st_size > 5000 and figure.title and figure.caption for figure in drawn)


def test_no_figures_without_a_path():
    assert path_drawers(_decaying(), _scenario(paths=set())) == {}
