"""
A torpedo under its laws as one compiled loop: line of sight with the measured crab angle, autopilots, hull.

The functions are those that agents and vehicles call tick by tick; only the loop is the benchmark's. So its
states are those of the scenario's run, to the last bit.
"""

from __future__ import annotations

from typing import NamedTuple

from auv_control.courses.line_of_sight import Params as Course
from auv_control.guidance.autopilots import initial_state, step_autopilots
from auv_control.guidance.crab.measured import low_passed
from auv_control.guidance.line_of_sight import aim_at_lane
from auv_control.guidance.paths import make_path
from auv_control.guidance.track import Floats, followed, piece_at
from auv_core.compiled import entry, fastest, record
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Numbers
from auv_core.models._torpedo_body import limited
from auv_core.models.torpedo import Model, Params, advance
from auv_experiment.scenario.schema import Scenario


@record("float64, float64, float64, float64, float64, float64, float64")
class Lane(NamedTuple):
    """Round, lane and lookahead (m), share of the low pass, depth (m), speed (m/s) and control period (s)."""

    round_m: float
    lane_m: float
    lookahead_m: float
    crab_share: float
    depth_m: float
    speed_mps: float
    period_s: float


@record("TUPLE42, float64, float64, TUPLE3, float64, int64")
class Plant(NamedTuple):
    """A hull's numbers and its limits (rad, rpm), the current (m/s; NED), a step (s), steps per period."""

    numbers: Numbers
    fin_max_rad: float
    propeller_max_rpm: float
    current_ned_mps: Vec3
    dt_s: float
    steps: int


@entry("TUPLE16(TUPLE16, float64, TUPLE5, float64[:, ::1], Lane, TUPLE32, Plant, int64)", allocates=False)
def fly(
    x: State, s_m: float, memory: Numbers, rows: Floats, lane: Lane, gains: Numbers, plant: Plant, ticks: int
) -> State:
    """
    Return the state of a torpedo after some control periods.

    Parameters
    ----------
    x : (16,) tuple
        State at the start.
    s_m : float
        Parameter of the track (m) that is closest to it.
    memory, gains : (5,) and (32,) tuple
        Of the autopilots.
    rows : (n, 6) array
        The track.
    lane, plant : Lane, Plant
        What else the laws and the hull need.
    ticks : int
        Number of control periods.

    """
    index, beta = piece_at(rows, lane.round_m, s_m), 0.0
    for tick in range(ticks):
        if tick > 0:
            index, s_m = followed(rows, lane.round_m, s_m, x[0], x[1])
        aim = aim_at_lane(x[:13], rows, lane.round_m, index, s_m, lane.lane_m, lane.lookahead_m)
        beta = low_passed(aim[5] if tick == 0 else beta, aim[5], lane.crab_share)
        setpoint = (aim[0] - beta, aim[1], lane.depth_m, lane.speed_mps)
        given = step_autopilots(x[:13], aim[4], setpoint, memory, lane.period_s, gains)
        memory = given[3:]
        command = limited(given[:3], plant.fin_max_rad, plant.propeller_max_rpm)
        x = advance(x, command, plant.current_ned_mps, plant.numbers, plant.dt_s, plant.steps)
    return x


class TorpedoRun:
    """A scenario with one torpedo on a course by line of sight, whose laws and hull fly in one loop."""

    def __init__(self, scenario: Scenario) -> None:
        vehicle, agent = scenario.vehicles[0], scenario.agent
        hull: Params = vehicle.model.params
        course: Course = agent.course.params if agent.course else Course()
        model, track, crab = Model(hull), make_path(course.path).track, course.crab.params
        north_m, east_m, down_m = vehicle.position_ned_m or (0.0, 0.0, 0.0)
        self._ticks, steps = scenario.ticks, round(scenario.period_s / scenario.dt_s)
        self.steps = scenario.ticks * steps
        self._start = (
            model.initial_state((north_m, east_m, down_m), vehicle.heading_rad, vehicle.speed_mps),
            track.closest(north_m, east_m),
            initial_state(down_m).numbers,
            track.rows,
            Lane(
                track.round_m,
                course.lane_m,
                crab.lookahead_m,
                crab.share(scenario.period_s),
                course.depth_m,
                course.speed_mps,
                scenario.period_s,
            ),
            agent.controller.params.gains.numbers,
            Plant(
                model.numbers,
                hull.servos.fin_max_rad,
                hull.servos.propeller_max_rpm,
                scenario.environment.current_ned_mps,
                scenario.dt_s,
                steps,
            ),
        )
        self._fly = fastest(fly)

    def fly(self) -> State:
        """Return the state at the end, flown from the start."""
        return self._fly(*self._start, self._ticks)
