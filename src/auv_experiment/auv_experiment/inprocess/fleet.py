"""
A flock in continuous time with the compiled loop of `fleet_loop`: conversion of a scenario to arrays and
back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_control.controllers import velocity_pi
from auv_control.references import PathPoint, make_reference
from auv_core.compiled import fastest
from auv_core.geometry import Vec3, quaternion_from_heading
from auv_core.models import kinematic, six_dof
from auv_core.pairs import near_pairs, no_pairs
from auv_experiment.inprocess.fleet_loop import Course, FleetLog, FleetState, lists_pairs, run_fleet
from auv_experiment.inprocess.hull_lanes import (
    LANES,
    Hull,
    from_lanes,
    hull_rates,
    point_rates,
    to_lanes,
)
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Scenario, VehicleEntry
from auv_flocking.consensus import thesis
from auv_flocking.flock_rates import FlockLaw, Paths, flock_law, flock_rates, guides
from auv_flocking.flocking import Member, potential
from auv_flocking.separation import CentralLaw, make_separation
from auv_sim.vehicle import check_finite

Floats = NDArray[np.float64]

_LOGGED_ROWS = 20_000
_MOST_TICKS = 1000


def has_compiled_form(scenario: Scenario) -> bool:
    """
    Return whether the compiled loop supports all laws of a flock and its vehicles.

    It supports the flocking law ``potential``, the consensus filter ``thesis``, separation laws that act
    along the line between two, and points, or hulls that are all of one ``six_dof`` model under
    ``velocity_pi``.
    """
    agent = scenario.agent
    if agent.flocking is None or agent.separation is None or agent.consensus is None:
        return False
    if (
        type(agent.flocking.params) is not potential.Params
        or type(agent.consensus.params) is not thesis.Params
    ):
        return False
    if not isinstance(make_separation(agent.separation), CentralLaw):
        return False
    models = [vehicle.model.params for vehicle in scenario.vehicles]
    if all(type(params) is kinematic.Params for params in models):
        return True
    is_hulls = type(models[0]) is six_dof.Params and all(params == models[0] for params in models)
    return is_hulls and type(agent.controller.params) is velocity_pi.Params


class Fleet:
    """
    The arrays of a flock, and the loop that flies them.

    Parameters
    ----------
    scenario : Scenario
        Laws, vehicles, path and water.
    starts : sequence of (3,) tuples, optional
        Positions (m; NED) of any number of vehicles like the scenario's first, instead of its own vehicles.

    """

    def __init__(self, scenario: Scenario, starts: Sequence[Vec3] | None = None) -> None:
        vehicles: Sequence[VehicleEntry] = scenario.vehicles
        if starts is not None:
            vehicles = [replace(vehicles[0], position_ned_m=start) for start in starts]
        self.count = len(vehicles)
        self._law = _law(scenario, [vehicle.id in scenario.leaders for vehicle in vehicles])
        references = [vehicle.reference or scenario.reference for vehicle in vehicles]
        distinct = [section for i, section in enumerate(references) if section not in references[:i]]
        self._path_of = np.array([distinct.index(section) for section in references])
        self._guide_of = np.array(guides([vehicle.id in scenario.leaders for vehicle in vehicles]))
        self._paths = [make_reference(section) for section in distinct if section]
        positions = [vehicle.position_ned_m or (0.0, 0.0, 0.0) for vehicle in vehicles]
        self.centres = np.array(positions)
        self.is_hull = not scenario.kinematic
        if self.is_hull:
            params = vehicles[0].model.params
            model = six_dof.Model(params)
            hulls = [
                (*model.initial_state(start, vehicle.heading_rad, vehicle.speed_mps), 0.0, 0.0, 0.0)
                for start, vehicle in zip(positions, vehicles, strict=True)
            ]
            self.motion = to_lanes(hulls)
            self._hull = Hull(
                model=six_dof.constants(params),
                limits=six_dof.limits(params),
                gains=scenario.agent.controller.params.gains,
                water_mps=scenario.environment.current_ned_mps,
            ).numbers
        else:
            self.motion, self._hull = self.centres.copy(), np.zeros(0)
        pairs = near_pairs if lists_pairs(self.count, self._law.numbers) else no_pairs
        rates = hull_rates if self.is_hull else point_rates
        strengths = self._law.strength, self._law.obstacle_strength
        self._functions = (fastest(pairs), fastest(flock_rates), fastest(rates), *strengths)
        self._run: Any = fastest(run_fleet)

    def paths(self, first_step: int, steps: int, dt_s: float) -> Floats:
        """Return the (2 * steps + 1, P, 8) table of the paths every half step, for `run_fleet`."""
        halves = range(2 * first_step, 2 * (first_step + steps) + 1)
        return np.array([[_path_row(path.at(0.5 * half * dt_s)) for path in self._paths] for half in halves])

    def run(self, ticks: int, steps: int, dt_s: float, paths: Floats) -> FleetLog:
        """Fly `ticks` control periods of `steps` steps along a table of `paths`; return the log."""
        wrenches = (ticks + 1, len(self.motion), 6 * LANES) if self.is_hull else (0, 0, 0)
        log = FleetLog(
            motion=np.empty((ticks + 1, *self.motion.shape)),
            centres=np.empty((ticks + 1, self.count, 3)),
            centre_rates=np.empty((ticks + 1, self.count, 3)),
            velocities=np.empty((ticks + 1, self.count, 3)),
            wrenches=np.empty(wrenches),
        )
        state = FleetState(self.motion, self.centres, self._law.numbers, self._hull)
        self._run(
            *self._functions,
            state,
            Course(ticks, steps, dt_s, Paths(paths, self._path_of, self._guide_of)),
            log,
        )
        return log


def fly_fleet(scenario: Scenario, recording: Recording, on_progress: Callable[[float], None] | None) -> None:
    """
    Fly a flock through all its ticks and write them into `recording`.

    Raises
    ------
    DivergedError
        If a motion has no finite solution.

    """
    fleet = Fleet(scenario)
    steps = round(scenario.period_s / scenario.dt_s)
    chunk = max(1, min(_MOST_TICKS, _LOGGED_ROWS // fleet.count))
    for tick in range(0, scenario.ticks, chunk):
        ticks = min(chunk, scenario.ticks - tick)
        paths = fleet.paths(tick * steps, ticks * steps, scenario.dt_s)
        _record(recording, tick, fleet, fleet.run(ticks, steps, scenario.dt_s, paths))
        if on_progress is not None:
            on_progress((tick + ticks) * scenario.period_s)


def _record(recording: Recording, tick: int, fleet: Fleet, log: FleetLog) -> None:
    """Write consecutive ticks from `tick` on; of the last one only the state."""
    states = slice(tick, tick + len(log.motion))
    commands = slice(tick, tick + len(log.motion) - 1)
    hulls = from_lanes(log.motion, fleet.count) if fleet.is_hull else log.motion
    _check_finite(recording, tick, hulls)
    recording.position_ned_m[states] = hulls[..., :3]
    recording.centre_ned_m[commands] = log.centres[:-1]
    recording.centre_velocity_ned_mps[commands] = log.centre_rates[:-1]
    recording.reference_velocity_ned_mps[commands] = log.velocities[:-1]
    if fleet.is_hull:
        recording.attitude_quat_wxyz[states] = hulls[..., 3:7]
        recording.velocity_body[states] = hulls[..., 7:13]
        recording.command[commands] = from_lanes(log.wrenches, fleet.count)[:-1]
    else:
        recording.attitude_quat_wxyz[states] = (1.0, 0.0, 0.0, 0.0)
        recording.velocity_body[states, :, :3] = log.velocities
        recording.velocity_body[states, :, 3:] = 0.0


def _check_finite(recording: Recording, tick: int, states: Floats) -> None:
    """Raise `DivergedError` for the first state that is not finite."""
    bad = np.argwhere(~np.isfinite(states).all(axis=-1))
    if bad.size:
        late, index = bad[0]
        name, t_s = recording.vehicle_ids[index], float(recording.t_s[tick + late])
        check_finite(tuple(states[late, index].tolist()), name, t_s)


def _law(scenario: Scenario, is_leader: Sequence[bool]) -> FlockLaw:
    agent = scenario.agent
    assert agent.flocking is not None
    assert agent.separation is not None
    assert agent.consensus is not None
    separation = make_separation(agent.separation)
    assert isinstance(separation, CentralLaw)
    consensus = thesis.Consensus(agent.consensus.params, len(is_leader))
    law_of = {
        leads: potential.Flocking(agent.flocking.params, separation, Member(leads)) for leads in (True, False)
    }
    laws = [law_of[leads] for leads in is_leader]
    obstacles = tuple((o.position_ned_m, o.safety_distance_m) for o in scenario.environment.obstacles)
    return flock_law(laws, agent.flocking.params, separation, consensus, obstacles)


def _path_row(point: PathPoint) -> tuple[float, ...]:
    """Return a path point as the eight numbers of `flock_rates`."""
    facing = quaternion_from_heading(point.heading_rad)
    return (*point.position, *point.velocity, facing[0], facing[3])
