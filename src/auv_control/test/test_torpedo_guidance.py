"""Claims about guidance and autopilots on the torpedo `remus100`: steps, paths in a current, waypoints."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from torpedo_flights import preset

from auv_control.guidance.autopilots import Params, Setpoint, initial_state, measured, piloted
from auv_control.guidance.crab import alos, ilos
from auv_control.guidance.crab import measured as measured_crab
from auv_control.guidance.line_of_sight import aimed, over_ground, sight
from auv_control.guidance.paths import circle, lawnmower, racetrack, waypoints
from auv_core import compiled
from auv_core.geometry import heading_from_quaternion
from auv_core.messages import VehicleState
from auv_core.models import make_model

PERIOD_S, STEP_S, SPEED_MPS, DEPTH_M = 0.1, 0.05, 1.5, 30.0
STILL = (0.0, 0.0, 0.0)
GAINS = Params().gains
CRABS = {"measured": measured_crab, "alos": alos, "ilos": ilos}
PATHS = {
    "line": lambda: waypoints.Path(waypoints.Params(waypoints_ned_m=(0.0, 0.0, 1000.0, 0.0))),
    "circle 50": lambda: circle.Path(circle.Params(radius_m=50.0)),
    "circle 40": lambda: circle.Path(circle.Params(radius_m=40.0)),
    "lawnmower": lambda: lawnmower.Path(lawnmower.Params()),
    "racetrack": lambda: racetrack.Path(racetrack.Params(straight_m=300.0, radius_m=80.0)),
}
# Path, law: rms and largest cross-track error (m) at 0, 0.3 and 0.5 m/s of current; None: infeasible
TABLE = {
    ("line", "measured"): ((0.0, 0.01), (0.0, 0.01), (0.01, 0.04)),
    ("line", "alos"): ((0.04, 0.09), (0.06, 0.13), (0.09, 0.18)),
    ("circle 50", "measured"): ((0.0, 0.0), (0.25, 0.43), (0.56, 1.16)),
    ("circle 50", "alos"): ((0.01, 0.02), (1.89, 2.97), (3.25, 5.63)),
    ("circle 40", "measured"): ((0.0, 0.0), (0.36, 0.62), None),
    ("circle 40", "alos"): ((0.01, 0.01), (2.1, 3.2), None),
    ("lawnmower", "measured"): ((0.06, 0.17), (0.20, 0.60), (0.81, 3.2)),
    ("lawnmower", "alos"): ((0.40, 0.76), (1.6, 3.3), (2.6, 6.1)),
    ("racetrack", "measured"): ((0.04, 0.11), (0.10, 0.37), (0.22, 0.84)),
    ("racetrack", "alos"): ((0.26, 0.57), (1.1, 2.4), (1.9, 4.5)),
}
CELLS = [
    (path, law, current_mps, bars)
    for (path, law), row in TABLE.items()
    for current_mps, bars in zip((0.0, 0.3, 0.5), row, strict=True)
    if bars is not None
]


class Row(NamedTuple):
    """One control period of a flight along a path: time (s), cross-track error (m), piece, position (m)."""

    t_s: float
    cross_track_m: float
    piece: int
    north_m: float
    east_m: float


@pytest.fixture
def torpedo(monkeypatch):
    """The model, compiled."""
    monkeypatch.setattr(compiled, "_is_on", True)
    return make_model(preset("remus100"))


def steps(torpedo, heading_deg, dive_m, speed_mps, *, duration_s):
    """Return heading (rad) and depth (m) in every control period; both steps come after 10 s."""
    state = torpedo.initial_state((0.0, 0.0, 10.0), 0.0, speed_mps)
    pilot, rows = initial_state(10.0), []
    for tick in range(round(duration_s / PERIOD_S)):
        steps_now = tick * PERIOD_S >= 10.0 - 1e-9
        nav = VehicleState(tick, state[:3], state[3:7], state[7:13])
        rows.append((heading_from_quaternion(nav.attitude), nav.position[2]))
        wanted = Setpoint(math.radians(heading_deg) * steps_now, 0.0, 10.0 + dive_m * steps_now, speed_mps)
        fins, pilot = piloted(measured(nav.numbers, nav.nu[0]), wanted, pilot, PERIOD_S, GAINS)
        state = torpedo.step(state, torpedo.limited_command(fins), STILL, STEP_S, 2)
    return np.unwrap([row[0] for row in rows]), np.array([row[1] for row in rows])


def followed(torpedo, path, law, current, *, duration_s, aside_m=0.0):
    """Return the rows of a flight along a path that starts beside it."""
    start = path.track.at(0.0)
    north_m = start.north_m - aside_m * math.sin(start.course_rad)
    east_m = start.east_m + aside_m * math.cos(start.course_rad)
    state = torpedo.initial_state((north_m, east_m, DEPTH_M), start.course_rad, SPEED_MPS)
    pilot, crab, place, rows = initial_state(DEPTH_M), None, path.engage(north_m, east_m), []
    for tick in range(round(duration_s / PERIOD_S)):
        nav = VehicleState(tick, state[:3], state[3:7], state[7:13])
        own = over_ground(nav)
        place = path.follow(place, own.north_m, own.east_m)
        if path.is_smooth and not path.track.is_closed and place.s_m > path.track.length_m:
            break
        found = sight(aimed(own, path.track.point(*place), 0.0, law.lookahead_m), law, crab)
        crab = found.crab
        rows.append(Row(tick * PERIOD_S, found.cross_track_m, place.piece, own.north_m, own.east_m))
        wanted = Setpoint(found.heading_rad, found.turn_rate_radps, DEPTH_M, SPEED_MPS)
        fins, pilot = piloted(measured(nav.numbers, found.along_mps), wanted, pilot, PERIOD_S, GAINS)
        state = torpedo.step(state, torpedo.limited_command(fins), current, STEP_S, 2)
    return rows


def currents(speed_mps, *, directions=4):
    """Return currents in some directions (m/s; NED), one if there is none."""
    angles = np.arange(directions if speed_mps else 1) * math.tau / directions
    return [(speed_mps * math.cos(angle), speed_mps * math.sin(angle), 0.0) for angle in angles]


def assert_within(torpedo, name, kind, flow, bars):
    path = PATHS[name]()
    law = CRABS[kind].Crab(CRABS[kind].Params(), PERIOD_S)
    is_mown = name == "lawnmower"
    aside_m = 10.0 if name == "line" else 0.0
    rows = followed(torpedo, path, law, flow, duration_s=1000.0 if is_mown else 500.0, aside_m=aside_m)
    from_s = 60.0 if is_mown else 150.0
    errors_m = np.array([row.cross_track_m for row in rows if row.t_s >= from_s])
    assert math.sqrt((errors_m**2).mean()) <= 1.3 * bars[0] + 0.05
    assert abs(errors_m).max() <= 1.3 * bars[1] + 0.05


def test_steps_of_heading_and_depth(torpedo):
    """Manoeuvre M3 of the specification: 30 deg and 10 m at 1.5 m/s."""
    heading, depth_m = steps(torpedo, 30.0, 10.0, 1.5, duration_s=90.0)
    at_s = {t_s: round(t_s / PERIOD_S) for t_s in (12, 14, 16, 20, 30, 40, 60)}
    turned = [math.degrees(heading[at_s[t_s]]) for t_s in (12, 14, 16, 20, 30)]
    np.testing.assert_allclose(turned, [8.97, 17.77, 24.16, 29.75, 30.91], atol=0.1)
    dived = [depth_m[at_s[t_s]] for t_s in (14, 20, 30, 40, 60)]
    np.testing.assert_allclose(dived, [10.605, 12.842, 16.342, 19.632, 20.021], atol=0.01)
    assert math.degrees(heading.max()) - 30.0 == pytest.approx(0.99, abs=0.1)
    assert depth_m.max() - 20.0 == pytest.approx(0.53, abs=0.02)


def settled_s(values, final, within):
    """Return how long after the step the values stay within a distance of the final one (s)."""
    outside = np.flatnonzero(abs(values - final) > within)
    return (outside[-1] + 1) * PERIOD_S - 10.0


@pytest.mark.parametrize(
    ("heading_deg", "speed_mps", "within_s"),
    [(30.0, 1.5, 8.1), (90.0, 1.5, 22.8), (170.0, 1.5, 42.1), (30.0, 1.0, 12.5), (90.0, 1.0, 37.4)],
)
def test_a_heading_step_settles(torpedo, heading_deg, speed_mps, within_s):
    heading, _ = steps(torpedo, heading_deg, 0.0, speed_mps, duration_s=70.0)
    settled = settled_s(np.degrees(heading), heading_deg, 2.0)
    assert settled == pytest.approx(within_s, rel=0.05)
    assert math.degrees(heading.max()) - heading_deg <= 1.02 * 1.05


@pytest.mark.parametrize(
    ("speed_mps", "within_s", "overshoot_m"), [(1.5, 40.0, 0.53), (2.0, 32.0, 0.60), (1.0, 111.0, 0.21)]
)
def test_a_depth_step_settles(torpedo, speed_mps, within_s, overshoot_m):
    _, depth_m = steps(torpedo, 0.0, 10.0, speed_mps, duration_s=140.0)
    assert settled_s(depth_m, 20.0, 0.2) == pytest.approx(within_s, rel=0.05)
    assert depth_m.max() - 20.0 == pytest.approx(overshoot_m, rel=0.05, abs=0.01)


def test_a_racetrack_in_a_current(torpedo):
    assert_within(torpedo, "racetrack", "measured", (0.0, 0.3, 0.0), (0.10, 0.37))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind", "current_mps", "bars"), CELLS)
def test_the_table_of_cross_track_errors(torpedo, name, kind, current_mps, bars):
    for flow in currents(current_mps):
        assert_within(torpedo, name, kind, flow, bars)


@pytest.mark.slow
@pytest.mark.parametrize("name", PATHS)
def test_the_integral_law_is_as_good_as_the_adaptive_one(torpedo, name):
    for flow in currents(0.3):
        assert_within(torpedo, name, "ilos", flow, TABLE[name, "alos"][1])


def corner_points():
    """Return the waypoints of three turns there and back (m; NED north, east), one after the other."""
    rows = [((200.0, y), (200.0, y + 80.0), (0.0, y + 80.0), (0.0, y + 160.0)) for y in (0.0, 160.0, 320.0)]
    return (0.0, 0.0, *(number for row in rows for point in row for number in point))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("current_mps", "soon_m", "later_m"), [(0.0, 2.8, 0.04), (0.3, 7.3, 0.12), (0.5, 15.3, 0.33)]
)
def test_corners_with_a_circle_of_acceptance(torpedo, current_mps, soon_m, later_m):
    """Largest cross-track error from 20 s and from 60 s after each switch; time at the last waypoint."""
    for flow in currents(current_mps):
        path = waypoints.Path(waypoints.Params(waypoints_ned_m=corner_points(), corners="switched"))
        law = measured_crab.Crab(measured_crab.Params(), PERIOD_S)
        rows = followed(torpedo, path, law, flow, duration_s=1060.0)
        last = len(path.track.pieces) - 1
        end = next(
            k for k, row in enumerate(rows)
            if row.piece == last and math.hypot(row.north_m, row.east_m - 480.0) <= 25.0
        )  # fmt: skip
        switched_s, soon, later = 0.0, 0.0, 0.0
        for before, row in pairwise(rows[:end]):
            switched_s = row.t_s if row.piece != before.piece else switched_s
            error_m = abs(row.cross_track_m)
            soon = max(soon, error_m) if row.t_s - switched_s > 20.0 else soon
            later = max(later, error_m) if row.t_s - switched_s > 60.0 else later
        assert soon <= 1.3 * soon_m + 0.05
        assert later <= 1.3 * later_m + 0.05
        assert 990.0 <= rows[end].t_s <= 1046.0
