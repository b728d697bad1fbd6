"""Claims about the limits of actuators, water, modem and report: a scenario that exceeds them is refused."""

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_bringup.tools import run as cli
from auv_control.references import circle, spiral
from auv_core.geometry import Box
from auv_core.models import hovering
from auv_core.params import ConfigError
from auv_experiment.metrics.safety import surface_metrics, surface_warning
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario
from auv_flocking.report import Report
from auv_flocking.reports import compact, exact

NO_OBSTACLES = "environment.obstacles=[]"


def _refusal(*overrides, name="flock_acoustic", **arguments):
    with pytest.raises(ConfigError) as refusal:
        load_scenario(name, overrides=overrides, **arguments)
    message = str(refusal.value)
    assert len(message.splitlines()) == 1
    return message


def _circle(radius_m, depth_m=10.0, speed_mps=0.1):
    """Return overrides for a circle, and for starts within it."""
    return (
        f"reference.params.radius_m={radius_m}",
        f"reference.params.rate_radps={speed_mps / radius_m}",
        f"reference.params.depth_m={depth_m}",
        f"random_starts.centre_ned_m=[0, {min(radius_m, 5230.0)}, {min(depth_m, 1130.0) + 1}]",
        NO_OBSTACLES,
    )


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (_circle(5250.0), "scenario.reference: reaches north -5257.94 m"),
        (_circle(5240.0), "scenario.reference: reaches north -5247.94 m"),
        (_circle(10.0, depth_m=1200.0), "scenario.reference: reaches down 1207.94 m"),
        (
            ("vehicles.0.position_ned_m=[0, -5243, 10]", *_circle(10.0)),
            "scenario.vehicles[0].position_ned_m: reaches east -5243 m",
        ),
    ],
)
def test_a_place_that_a_report_cannot_carry_is_refused(overrides, said):
    message = _refusal(*overrides)
    assert message.startswith(f"{said}, which is not allowed; allowed: "), message
    assert message.endswith("m, which a report of the kind compact carries")
    load_scenario(
        "flock_acoustic",
        overrides=[o for o in overrides if "position" not in o] + ["agent.report={kind: exact}"],
    )


@pytest.mark.parametrize("radius_m", [100.0, 5230.0])
def test_a_place_that_a_report_carries_is_allowed(radius_m):
    load_scenario("flock_acoustic", overrides=_circle(radius_m))


def test_coarser_reports_carry_farther():
    load_scenario(
        "flock_acoustic", overrides=[*_circle(5250.0), "agent.report.params.position_resolution_m=0.04"]
    )


def test_a_velocity_that_a_report_cannot_carry_is_refused():
    fast = ["agent.flocking.kind=communication_aware", "reference.params.rate_radps=0.15"]
    finer = "agent.report={kind: compact, params: {velocity_resolution_mps: 0.001}}"
    load_scenario("flock_acoustic", overrides=fast)
    message = _refusal(*fast, finer)
    assert message.startswith(
        "scenario.reference: lets vehicles[0] move at 1.82 m/s, which is not allowed; "
    ), message
    assert "at most 1.02 m/s, which a report of the kind compact carries" in message


def test_points_at_4_mps_are_refused_with_compact_reports():
    points = ["reference.params.rate_radps=0.4", "sampling=sampled"]
    message = _refusal(*points, "agent.report={kind: compact}", name="ch5_one_leader")
    assert "at most 2.56 m/s, which a report of the kind compact carries" in message
    load_scenario("ch5_one_leader", overrides=points)


def test_a_law_without_a_limit_is_judged_by_its_path():
    """The demand of its errors on a hull without a top speed is not known before the flight."""
    load_scenario("ch5_one_leader", overrides=["sampling=sampled", "agent.report={kind: compact}"])


def test_starts_too_far_apart_for_the_centre_in_a_report_are_refused():
    message = _refusal("vehicles.0.position_ned_m=[0, 100, 10]", "vehicles.1.position_ned_m=[0, 0, 10]")
    assert message.startswith(
        "scenario.vehicles: start 100 m apart (east), which is not allowed; allowed: at most 81.84"
    )


@given(
    st.tuples(*[st.floats(-6000.0, 6000.0)] * 3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.tuples(*[st.floats(-100.0, 100.0)] * 3),
)
def test_a_format_saturates_exactly_beyond_what_it_says_that_it_carries(position, velocity, centre):
    for module in (compact, exact):
        form = module.Format(module.Params(), ())
        bounds = form.carries
        at = tuple(x + dx for x, dx in zip(position, centre, strict=True))
        report = Report(1, 1.0, position, velocity, at, velocity, 1.0, position_sd_m=0.1)
        form.encode(report)
        is_within = (
            bounds.position.holds(position)
            and all(abs(v) <= bounds.velocity_mps for v in velocity[:2])
            and abs(velocity[2]) <= bounds.descent_mps
            and all(abs(c) <= bounds.centre_distance_m - 2.0 * form.position_resolution_m for c in centre)
        )
        if is_within:
            assert form.saturated == 0
        step_m, step_mps = form.position_resolution_m, form.velocity_resolution_mps
        beyond = (
            not bounds.position.grown(step_m).holds(position)
            or any(abs(v) > bounds.velocity_mps + 4.0 * step_mps for v in velocity[:2])
            or abs(velocity[2]) > bounds.descent_mps + 4.0 * step_mps
            or any(abs(c) > bounds.centre_distance_m + 8.0 * step_m for c in centre)
        )
        if beyond:
            assert form.saturated > 0


def test_a_current_that_the_actuators_cannot_hold_is_refused():
    for text in ("[2.5, 0, 0]", "[0, -1.3, 1.3]"):
        message = _refusal(f"environment.current_ned_mps={text}")
        assert message.startswith("scenario.environment.current_ned_mps: runs at "), message
        assert "at most 1.77 m/s, which the actuators of vehicles[0] hold against the drag" in message
    region = [
        "environment.current_ned_mps=[5, 0, 0]",
        "vehicles.0.model.params.max_wrench=[10, 10, 10, 9, 9, 9]",
    ]
    assert "environment.current_ned_mps" in _refusal(*region, name="ch4_region")


def test_a_current_beyond_the_force_that_the_controller_asks_for_is_refused():
    message = _refusal("agent.controller.params.max_force_n=1", "environment.current_ned_mps=[0.2, 0, 0]")
    assert message.startswith("scenario.environment.current_ned_mps: runs at 0.2 m/s"), message
    assert "which the controller and actuators of vehicles[0] hold against the drag" in message


def test_a_path_is_as_fast_as_it_runs_through_the_water():
    """1 m/s over ground is 2 m/s through a current of 1 m/s wherever the circle runs against it."""
    fast = "reference.params.rate_radps=0.1"
    load_scenario("flock_acoustic", overrides=[fast, "environment.current_ned_mps=[0, 0, 0]"])
    message = _refusal(fast, "environment.current_ned_mps=[1, 0, 0]")
    assert message.startswith("scenario.reference: runs at 2 m/s through the water"), message


def test_a_path_out_of_the_water_is_refused():
    rising = "reference={kind: spiral, params: {depth_m: 10, depth_rate_mps: -0.3}}"
    load_scenario("flock_acoustic", overrides=[rising], duration_s=30.0)
    message = _refusal(rising, duration_s=60.0)
    assert message.startswith("scenario.reference: rises 8 m above the surface within 60 s"), message


def test_a_region_out_of_the_water_is_refused():
    message = _refusal("agent.controller.params.centre_ned_m=[10, 10, 0.4]", name="ch4_region")
    assert message.startswith("scenario.agent.controller.params: rises 0.1 m above the surface"), message


def test_a_hull_that_belongs_to_the_surface_is_allowed():
    load_scenario("ch2_pfpd", overrides=["reference.params.depth_m=0"])


def test_a_path_below_the_bottom_is_refused(monkeypatch):
    from auv_sim.acoustics.propagation import bellhop

    monkeypatch.setattr(bellhop, "is_installed", lambda: True)
    monkeypatch.setattr(bellhop.Propagation, "__init__", lambda self, params: None)
    water = "acoustics.propagation={kind: bellhop, params: {water_depth_m: 50}}"
    deep = ["reference.params.depth_m=60", "random_starts.centre_ned_m=[0, 10, 30]", NO_OBSTACLES]
    load_scenario("flock_acoustic", overrides=[water])
    message = _refusal(water, *deep)
    assert message.startswith("scenario.reference: reaches a depth of 67.9"), message
    assert message.endswith("allowed: at most 50 m, acoustics.propagation.params.water_depth_m")


@pytest.mark.parametrize(
    "modem",
    [
        "acoustics.modem.params.max_range_m=5",
        "acoustics.modem={kind: noise_limited, params: {source_level_db: 40}}",
        # Recognised, but never without a bit error.
        "acoustics.modem={kind: noise_limited, params: {source_level_db: 75, acquisition_db: -60}}",
    ],
)
def test_a_vehicle_of_a_flock_that_nobody_can_hear_is_refused(modem):
    assert ": out of range of vehicles[0]" in _refusal(
        modem, "acoustics.propagation={kind: straight}", "acoustics.modem.params.max_payload_bytes=128"
    )


@given(
    st.floats(0.5, 500.0),
    st.floats(-0.2, 0.2),
    st.floats(0.0, 50.0),
    st.floats(-1.0, 1.0),
    st.floats(1.0, 900.0),
)
def test_a_path_stays_within_the_reach_that_it_states(
    radius_m, rate_radps, depth_m, depth_rate_mps, duration_s
):
    paths = (
        circle.Reference(circle.Params(radius_m=radius_m, rate_radps=rate_radps, depth_m=depth_m)),
        spiral.Reference(
            spiral.Params(
                radius_m=radius_m, rate_radps=rate_radps, depth_m=depth_m, depth_rate_mps=depth_rate_mps
            )
        ),
    )
    for path in paths:
        reach = path.reach(duration_s).grown(1e-9)
        assert isinstance(reach, Box)
        assert all(reach.holds(path.at(duration_s * k / 50).position) for k in range(51))
        assert math.isfinite(sum(reach.lowest) + sum(reach.highest))


def test_hulls_in_the_air_are_counted_and_said(tmp_path, capsys):
    """A flock around a path at the surface has vehicles above it: allowed, and named in numbers and words."""
    run = ["ch5_four_leaders", "--duration", "40", "--no-bag", "--no-figures", "--out", str(tmp_path)]
    assert cli.main([*run, "--set", "reference.params.depth_m=0"]) == 0
    (folder,) = tmp_path.iterdir()
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["hull_in_air_ratio"] > 0.1
    assert 0.1 < metrics["hull_in_air_height_m"] < 5.0
    assert "warning: hulls were above the surface, by up to" in capsys.readouterr().err
    assert "Did hulls leave the water?" in (folder / "report.html").read_text()


def test_hulls_in_the_water_give_no_warning():
    recording = Recording.empty(["a", "b"], np.array([0.0, 0.1]))
    recording.position_ned_m[:] = (0.0, 0.0, -0.3)  # a hull of this radius still touches the water
    hull: Any = SimpleNamespace(handlings=2 * (hovering(0.3),))
    metrics = surface_metrics(recording, hull)
    assert metrics == {"hull_in_air_ratio": 0.0, "hull_in_air_height_m": None}
    assert surface_warning(metrics) == ""
    recording.position_ned_m[1, 1, 2] = -0.8
    metrics = surface_metrics(recording, hull)
    assert metrics == {"hull_in_air_ratio": 0.25, "hull_in_air_height_m": pytest.approx(0.5)}
    assert "by up to 0.50 m, for 25.0 % of the time" in surface_warning(metrics)
