"""Claim: a fleet or a course that its vehicles cannot fly is refused in one line, before anything starts."""

from __future__ import annotations

import pytest

from auv_core.params import ConfigError
from auv_experiment.scenario.loading import load_scenario

FLEET = "agent.fleet.params."
COURSE = "agent.course.params."


@pytest.mark.parametrize(
    ("name", "override", "words"),
    [
        ("torpedo_path", ["dt_s=0.5", "period_s=0.5"], "dt_s: 0.5 is not allowed; allowed: at most 0.2 s"),
        (
            "torpedo_path",
            "environment.current_ned_mps=[.nan, 0, 0]",
            "environment.current_ned_mps[0]: nan is",
        ),
        (
            "torpedo_path",
            "environment.current_ned_mps=[0, 0.9, 0]",
            f"{COURSE}lane: 1.5 m/s in the lane at 0 m is not allowed; allowed: none in a current of 0.9 m/s",
        ),
        (
            "torpedo_path",
            "vehicles.0.speed_mps=9",
            "vehicles[0].speed_mps: 9.0 m/s over ground is 9 m/s through",
        ),
        ("torpedo_path", f"{COURSE}path.params.radius_m=-80", f"{COURSE}path.params.radius_m: -80.0 is not"),
        (
            "torpedo_path",
            f"{COURSE}path={{kind: waypoints, params: {{waypoints_ned_m: [0, 0, 0]}}}}",
            f"{COURSE}path.params.waypoints_ned_m: ",
        ),
        (
            "torpedo_fleet",
            f"{FLEET}path={{kind: racetrack, params: {{straight_m: 90000}}}}",
            "agent.fleet.params: reaches north",
        ),
        (
            "torpedo_fleet",
            f"{FLEET}spacing_m=1",
            f"{FLEET}spacing_m: slots 1 m apart are not allowed; allowed: ",
        ),
        (
            "torpedo_fleet",
            f"{FLEET}depth_m=5",
            f"{FLEET}depth_m: 5.0 is not allowed; allowed: more than 12 m",
        ),
        (
            "torpedo_fleet",
            f"{FLEET}least_speed_mps=3",
            f"{FLEET}least_speed_mps: 3.0 is not allowed; allowed: ",
        ),
        ("torpedo_fleet", f"{FLEET}transit_speed_mps=6", f"{FLEET}transit_speed_mps: 6.0 is not allowed; "),
        ("torpedo_fleet", f"{FLEET}transit_speed_mps=0.1", f"{FLEET}transit_speed_mps: 0.1 is not allowed; "),
        (
            "torpedo_fleet",
            f"{FLEET}loiter_radius_m=5",
            f"{FLEET}loiter_radius_m: 5.0 is not allowed; allowed: ",
        ),
        (
            "torpedo_fleet",
            "vehicles.1.position_ned_m=[60, 21, 36]",
            "vehicles[1].position_ned_m: touches vehi",
        ),
        (
            "hover_thrusters",
            "vehicles.1.fault.thruster=9",
            "vehicles[1].fault.thruster: 9 is not allowed; allo",
        ),
    ],
)
def test_what_cannot_be_flown_is_refused_in_one_line(
    name: str, override: str | list[str], words: str
) -> None:
    with pytest.raises(ConfigError) as refused:
        load_scenario(name, overrides=[override] if isinstance(override, str) else override)
    line = str(refused.value)
    assert line.startswith(f"scenario.{words}"), line
    assert "allowed: " in line
    assert "\n" not in line
