"""Claims about every plugin of every plugin folder; a new file is tested here automatically."""

import copy
import importlib
import inspect
import itertools
import math
from collections.abc import Callable
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol

import numpy as np
import pytest
import yaml

from auv_control.allocation import ThrusterAllocator
from auv_control.controllers import (
    CourseController,
    MotionLaw,
    MotionView,
    VelocityController,
    VelocityReference,
    autopilot,
)
from auv_control.courses import CourseLaw, Guided
from auv_control.guidance.autopilots import Setpoint
from auv_control.guidance.crab import CrabLaw, CrabView
from auv_control.guidance.paths import GuidancePath
from auv_control.references import PathPoint, ReferencePath
from auv_core.contracts import fulfilled, members
from auv_core.geometry import distance
from auv_core.messages import COMMANDS, FinCommand, VehicleState, VelocityCommand, Wrench
from auv_core.models import ContinuousModel, VehicleModel, make_model
from auv_core.params import ConfigError, dump, load, load_section
from auv_core.plugins import find_plugin, list_plugins
from auv_core.thrusters import Thrusters
from auv_flocking.central import along
from auv_flocking.codec import Field, Layout
from auv_flocking.consensus import ConsensusFilter, ContinuousFilter
from auv_flocking.coordination import CoordinationLaw, LanePlace, Pace
from auv_flocking.estimators import Motion, NeighbourEstimator
from auv_flocking.fleets import FleetTask, Mission
from auv_flocking.flocking import NOTHING_HEARD, FlockingLaw, Member, View
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus, Mode
from auv_flocking.neighbours.estimates import NeighbourEstimate
from auv_flocking.neighbours.rivals import Leftovers
from auv_flocking.neighbours.sonar_contact import contact_of, sighting
from auv_flocking.report import NEVER, Report, ReportError
from auv_flocking.reports import ReportFormat
from auv_flocking.separation import (
    CentralLaw,
    LearningLaw,
    ObstacleLaw,
    PotentialLaw,
    SeparationLaw,
    mathematical,
    obstacle_velocity_of,
)
from auv_flocking.trackers import ObstacleTracker
from auv_sim.acoustics.mac import MediumAccess, SensingAccess
from auv_sim.acoustics.modem import AcousticModem, LevelModem
from auv_sim.acoustics.outage import PacketLoss
from auv_sim.acoustics.propagation import SoundPropagation
from auv_sim.acoustics.sonar import HullSonar
from auv_sim.currents import WaterCurrent
from auv_sim.navigation import OwnNavigation
from auv_sim.obstacles import ObstacleMotion

PERIOD_S = 0.1
PACE = Pace(1.5, 1742.5, PERIOD_S)
MEAN_NED_MPS = (0.08, 0.06, 0.0)
SEPARATION = mathematical.Separation(mathematical.Params())
PAIR = Thrusters(
    positions_m=(0.0, 0.3, 0.0, 0.0, -0.3, 0.0),
    directions=(1.0, 0.0, 0.0) * 2,
    max_forward_n=(20.0,),
    max_backward_n=(10.0,),
)


class _Inputs:
    """Inputs that repeat: the same calls give the same points, and every one handed out is remembered."""

    def __init__(self):
        self._rng = np.random.default_rng(1)
        self._given = []

    def kept(self, value):
        self._given.append((value, copy.deepcopy(value)))
        return value

    def point(self, size=10.0):
        return self.kept(tuple(self._rng.uniform(-size, size, 3).tolist()))

    def points(self, count):
        return self.kept([tuple(self._rng.uniform(-3.0, 3.0, 3).tolist()) for _ in range(count)])

    def numbers(self, count, size):
        return self.kept(tuple(self._rng.uniform(-size, size, count).tolist()))

    def six(self, size):
        return self.kept(tuple(self._rng.uniform(-size, size, 6).tolist()))

    def attitude(self):
        q = self._rng.normal(size=4)
        return self.kept(tuple((q / np.linalg.norm(q)).tolist()))

    def view(self):
        obstacles = ((self.point(), 2.0),)
        path = PathPoint(self.point(), self.point(0.1))
        neighbours = tuple(self.points(4))
        seen = self.kept(View(self.point(3.0), self.point(), self.point(0.2), neighbours, obstacles, path))
        return seen._replace(estimates=tuple(self._estimate(k, p) for k, p in enumerate(neighbours, start=2)))

    def _estimate(self, address, position):
        velocity, flock_velocity, centre = self.point(0.2), self.point(0.1), self.point()
        covariance = np.diag([0.01 * address] * 3 + [0.001] * 3)
        return NeighbourEstimate(
            address, position, velocity, covariance, 0.7 * address, centre, flock_velocity, -0.5, time_s=-0.7
        )

    def assert_unchanged(self):
        for value, before in self._given:
            assert repr(value) == repr(before)


def _fly_model(module, params, inputs):
    model = module.Model(params)
    assert model.command in COMMANDS
    handling = model.handling
    assert 0.0 < handling.hull_diameter_m <= handling.hull_length_m == 2.0 * handling.hull_radius_m
    assert handling.can_stop == (handling.least_speed_mps == 0.0)
    assert handling.can_stop or model.turn_radius_m(handling.least_speed_mps) > 0.0
    state = model.initial_state(inputs.point(), 0.7)
    outputs: list[Any] = []
    for size in (0.1, 10.0, 1e4):
        given = model.limited_command(inputs.numbers(len(model.resting_command()), size))
        for _ in range(5):
            state = model.step(state, given, inputs.point(0.0 if model.command == "velocity" else 0.2), 0.02)
            assert len(state) == 13 + len(model.actuators)
            assert math.hypot(*state[3:7]) == pytest.approx(1.0, abs=1e-9)
            outputs.append((given, state))
        if isinstance(model, ContinuousModel):
            outputs.append(
                model.normalised(model.derivative(state, given, inputs.point(0.2))[:3] + state[3:])
            )
            outputs.append(model.kinetic_energy(state[7:13]))
            assert outputs[-1] > 0.0
    assert model.top_speed_mps > 0.0
    assert 0.0 < model.speed_held_mps(1.0) <= model.speed_held_mps(math.inf) == model.top_speed_mps
    return outputs


def _use_controller(module, params, inputs):
    controller = module.Controller(params, PERIOD_S)
    if controller.follows == "course":
        return _use_autopilots(controller, inputs)
    if controller.follows != "velocity":
        return _use_motion_law(controller, params, inputs)
    made: Any = {"wrench": Wrench, "velocity": VelocityCommand}[controller.command]
    outputs: list[Any] = []
    for tick in range(20):
        nav = VehicleState(tick, inputs.point(), inputs.attitude(), inputs.six(1.0))
        command = controller.step(nav, VelocityReference(inputs.point(1.0), 0.5))
        assert isinstance(command, made)
        outputs.append(command.tau if made is Wrench else (*command.velocity, command.yaw_rate_radps))
    return outputs


def _use_autopilots(controller, inputs):
    assert controller.command == "fins"
    assert controller.state == ()
    outputs: list[Any] = [tuple(controller.safe_command)]
    for tick in range(20):
        nav = VehicleState(tick, inputs.point(), inputs.attitude(), inputs.six(1.0))
        guided = Guided(Setpoint(0.3, 0.01, inputs.point()[2], 1.5), *inputs.point(1.0)[:2])
        command = controller.step(nav, inputs.kept(guided))
        assert isinstance(command, FinCommand)
        outputs.append((tuple(command), controller.state))
    return outputs


@cache
def _remus100():
    (path,) = [path for path in _presets("auv_core.models") if path.stem == "remus100"]
    return make_model(load_section(yaml.safe_load(path.read_text()), "remus100", "auv_core.models"))


def _use_course(module, params, inputs):
    course = module.Course(params, PERIOD_S)
    vehicle = _remus100()
    course.check(vehicle, 0.2)
    with pytest.raises(ValueError, match=r"^[a-z_]+: .* is not allowed; allowed: "):
        course.check(vehicle, 2.0)
    reach = course.reach(650.0)
    assert reach is None or all(low <= high for low, high in zip(*reach, strict=True))
    outputs: list[Any] = []
    for tick in range(200):
        nav = VehicleState(tick, inputs.point(), inputs.attitude(), inputs.six(1.0))
        guided = course.step(PERIOD_S * tick, nav)
        assert math.isnan(guided.cross_track_m) == (reach is None)
        outputs.append((tuple(guided.setpoint), guided.along_mps))
    return outputs


def _use_fleet(module, params, inputs):
    controller = autopilot.Controller(autopilot.Params(), PERIOD_S)
    task = module.Fleet(params, Member(address=2, fleet_size=3), controller, PERIOD_S, Mission(cycle_s=6.0))
    layout, outputs = Layout(task.shared_fields), []
    level = (math.cos(0.2), 0.0, 0.0, math.sin(0.2))
    for tick in range(100):
        nav = VehicleState(tick, inputs.point(50.0), level, inputs.six(0.5))
        shared = (0.0,) * len(layout.fields)
        other = NeighbourEstimate(
            1, inputs.point(), inputs.point(1.0), np.eye(6), 0.2, nav.position, (0.0, 0.0, 0.0),
            time_s=0.1 * (tick - tick % 10), shared=shared,
        )  # fmt: skip
        command = task.step(PERIOD_S * tick, nav, inputs.kept([other]))
        layout.pack(task.shared())
        assert type(task.sends(PERIOD_S * tick)) is bool
        outputs.append((*command, *task.law_state, *task.shared()))
    assert type(task.safe_command) is type(command)
    return outputs


def _use_allocator(module, params, inputs):
    outputs = []
    for lost in ((), (2,)):
        allocator = module.Allocator(params, PAIR, lost)
        for size in (1.0, 30.0, 1e4):
            tau = inputs.six(size)
            forces = allocator.forces_n(tau)
            assert allocator.forces_n(tau) == forces
            assert all(-10.0 <= force <= 20.0 for force in forces)
            assert all(forces[number - 1] == 0.0 for number in lost)
            outputs.append(forces)
    return outputs


def _motion_view(inputs, tick, follows):
    w, _, _, z = inputs.attitude()
    level = (w / math.hypot(w, z), 0.0, 0.0, z / math.hypot(w, z))
    nav = VehicleState(tick, inputs.point(), level, inputs.six(1.0))
    path = PathPoint(inputs.point(), inputs.point(0.1), inputs.point(0.01), 0.5)
    neighbours = tuple(inputs.points(2))
    return MotionView(
        0.1 * tick, nav, path if follows == "path" else None, neighbours, ((inputs.point(), 2.0),)
    )


def _use_motion_law(law, params, inputs):
    assert law.command == "wrench"
    assert law.follows in ("path", "region")
    assert len(law.proof_gap) > 20
    state = law.initial_state(_motion_view(inputs, 0, law.follows))
    outputs: list[Any] = []
    for tick in range(20):
        view = inputs.kept(_motion_view(inputs, tick, law.follows))
        tau, rate = law.evaluate(state, view)
        assert len(tau) == 6
        assert len(rate) == len(state)
        values = law.lyapunov(state, view, lambda nu: 50.0 * sum(x * x for x in nu))
        assert len(values) == len(law.candidates) > 0
        outputs.append((tau, rate, values))
        state = law.constrained(tuple(z + PERIOD_S * dz for z, dz in zip(state, rate, strict=True)))
        assert law.constrained(state) == state
    return outputs


def _follow_reference(module, params, _inputs):
    path = module.Reference(params)
    assert path.period_s is None or path.period_s > 0.0
    reach = path.reach(650.0).grown(1e-6)
    outputs, step_s = [], 1e-4
    for t_s in (0.0, 1.0, 123.4, 650.0):
        behind, now, ahead = path.at(t_s - step_s), path.at(t_s), path.at(t_s + step_s)
        for value, rate in (("position", "velocity"), ("velocity", "acceleration")):
            slope = np.subtract(getattr(ahead, value), getattr(behind, value)) / (2.0 * step_s)
            np.testing.assert_allclose(getattr(now, rate), slope, atol=1e-5)
        turned_rad = math.remainder(ahead.heading_rad - behind.heading_rad, 2.0 * math.pi)
        assert now.heading_rate_radps == pytest.approx(turned_rad / (2.0 * step_s), abs=1e-6)
        assert reach.holds(now.position)
        outputs.append(now)
    return outputs


def _follow_guidance_path(module, params, inputs):
    path = module.Path(params)
    assert path.track.length_m > 0.0
    place = path.engage(*inputs.point(300.0)[:2])
    outputs = [path.track.point(*place)]
    for _ in range(50):
        point = path.track.at(place.s_m)
        course_rad, (aside_m, *_) = point.course_rad, inputs.point(0.1)
        moved = (
            point.north_m + 1.5 * math.cos(course_rad) - aside_m * math.sin(course_rad),
            point.east_m + 1.5 * math.sin(course_rad) + aside_m * math.cos(course_rad),
        )
        place, before_m = path.follow(place, *moved), place.s_m
        assert abs(place.s_m - before_m - 1.5) < 0.05
        outputs.append(path.track.point(*place))
    return outputs


def _use_crab(module, params, inputs):
    law = module.Crab(params, PERIOD_S)
    assert law.lookahead_m > 0.0
    state, outputs = law.initial_state(CrabView(*inputs.point(0.5))), []
    for _ in range(200):
        beta, state = law.step(inputs.kept(state), CrabView(*inputs.point(0.5)))
        assert abs(beta) < 0.5 * math.pi
        outputs.append((beta, state))
    return outputs


def _use_flocking(module, params, inputs):
    outputs: list[Any] = []
    for is_leader in (True, False):
        law = module.Flocking(params, SEPARATION, Member(is_leader))
        assert params.formation_spacing_m > 0.0
        assert params.largest_correction_mps > 0.0
        belief = NOTHING_HEARD
        for tick in range(10):
            view = inputs.view()
            estimates = view.estimates if tick else ()
            law.hear(estimates, PERIOD_S)
            belief = law.flock_velocity(PERIOD_S * tick, view.path, view.centre, belief, estimates)
            assert is_leader <= (belief.stamp_s == PERIOD_S * tick)
            outputs.append((law.velocity(view), belief.velocity))
            law.adapt(view, PERIOD_S)
    return outputs


def _use_separation(module, params, inputs):
    law = module.Separation(params)
    own, others = inputs.point(1.0), [inputs.point(3.0) for _ in range(20)]
    outputs = [law.velocity(own, other, 2.0) for other in (own, *others)]
    if isinstance(law, ObstacleLaw):
        outputs += [law.obstacle_velocity(own, other, 2.0) for other in others]
    if isinstance(law, CentralLaw):
        assert law.reach_m(2.0) > 0.0
        of_obstacle = obstacle_velocity_of(law)
        for other in others:
            assert along(own, other, 2.0, law.strength, law.numbers) == law.velocity(own, other, 2.0)
            pushed = along(own, other, 2.0, law.obstacle_strength, law.obstacle_numbers)
            assert pushed == of_obstacle(own, other, 2.0)
    if isinstance(law, PotentialLaw):
        outputs += [(law.potential(r, 2.0), law.obstacle_potential(r, 2.0)) for r in (0.5, 1.0, 2.0, 5.0)]
    if isinstance(law, LearningLaw):
        law.adapt([1.5, 2.5], 2.0, PERIOD_S)
        outputs.append(law.velocity(own, others[0], 2.0))
    return outputs


def _use_consensus(module, params, inputs):
    consensus = module.Consensus(params, 4)
    layout = Layout(consensus.shared_fields)
    outputs: list[Any] = []
    held, own = (0.0,) * len(layout.fields), inputs.point()
    for tick in range(20):
        own = inputs.kept(tuple(x + 0.01 for x in own))
        heard = inputs.kept([
            NeighbourEstimate(
                address, own, own, np.eye(6), 0.1 * (tick % 4), own, (0.1, 0.0, 0.0),
                time_s=0.1 * (tick // 4), shared=held,
            )
            for address in range(2, 2 + min(tick // 5, 3))
        ])  # fmt: skip
        centre = consensus.centre(own, heard)
        rate = consensus.advance(own, heard, inputs.point(0.2), PERIOD_S)
        outputs.append((centre, rate))
        assert tick or centre == own, "it starts at the own position"
        if tick % 4 == 0:
            shared = consensus.shared()
            held = tuple(layout.unpack(layout.pack(shared)))
            assert len(shared) == len(layout.fields)
            outputs.append(shared)
    assert layout.saturated == 0
    if isinstance(consensus, ContinuousFilter):
        assert consensus.reach_m > 0.0
        arguments = (inputs.point(), inputs.point(), inputs.points(5), inputs.point(0.2))
        outputs.append(consensus.derivative(*arguments))
    return outputs


def _use_estimator(module, params, inputs):
    estimator = module.Estimator(params)
    rng, outputs = np.random.default_rng(2), []
    nav = VehicleState(0, inputs.point(), inputs.attitude(), inputs.six(0.1))
    contact = sighting(0.0, nav, contact_of((3.0, 2.0, 1.0)), 0.1, 0.02)
    for size in (6, 10):
        x, root = inputs.kept(rng.normal(0.0, 3.0, size)), rng.normal(0.0, 0.3, (size, size))
        P, H = inputs.kept(root @ root.T + 0.01 * np.eye(size)), inputs.kept(np.eye(6, size))
        for memory_s in (0.0, 15.0):
            motion = inputs.kept(Motion(2.0, 1e-3, 1e-8, memory_s, (0.1, 0.0, 0.0, 0.02)))
            outputs.append(estimator.predicted(x, P, motion))
        z, R = inputs.kept(rng.normal(0.0, 0.1, 6)), inputs.kept(0.01 * np.eye(6))
        after = estimator.updated(x, P, z, H, R)
        assert np.trace(after.P) < np.trace(P)
        np.testing.assert_allclose(after.precision, np.linalg.inv(H @ P @ H.T + R), rtol=1e-6, atol=1e-6)
        seen = estimator.seen(x, P, contact)
        assert (seen.innovation.shape, seen.precision.shape) == ((3,), (3, 3))
        outputs += [after, seen]
    for _, covariance, *_ in outputs:
        np.testing.assert_allclose(covariance, covariance.T, atol=1e-12)
    return [tuple(array.tolist() for array in arrays) for arrays in outputs]


def _use_format(module, params, inputs):
    outputs: list[Any] = []
    for shared in ((), (Field("sum", -8.0, 8.0, 0.125, wraps=True), Field("weight", 0.0, 1.0, 0.125))):
        form = module.Format(params, shared)
        assert form.carries.position.holds((0.0, 0.0, 0.0))
        assert min(form.carries.velocity_mps, form.carries.centre_distance_m) > 0.0
        numbers = (0.5, 0.25)[: len(shared)]
        for tick in range(1, 20):
            velocity, flock_velocity = inputs.point(1.0), inputs.point(1.0)
            report = Report(
                1 + tick, 0.1 * tick, inputs.point(), velocity, inputs.point(), flock_velocity,
                0.1 * (tick // 2), 0.01, 0.1 * tick, 0.5, tick % 2 == 0, tick % 3 == 0, tick % 16, tick,
                numbers,
            )  # fmt: skip
            payload = form.encode(inputs.kept(report))
            assert len(payload) == form.payload_bytes
            back = form.decode(inputs.kept(payload), 0.1 * tick + 3.0)
            assert (back.address, back.heard_mask, back.shared) == (1 + tick, tick, numbers)
            assert (back.is_bounded, back.is_holding) == (tick % 2 == 0, tick % 3 == 0)
            assert form.encode(back) == payload, "what was rounded is rounded no more"
            outputs.append((back.time_s, back.position, back.velocity, back.centre))
            assert back.flock_stamp_s in (NEVER, pytest.approx(report.flock_stamp_s))
            with pytest.raises(ReportError):
                form.decode(payload[:-1], 0.0)
        assert form.saturated == 0
        outputs.append((float(form.position_resolution_m), float(form.velocity_resolution_mps)))
    return outputs


def _use_coordination(module, params, inputs):
    assert params.correction_max_mps > 0.0
    law, outputs = module.Coordination(params, PACE), []
    own = LanePlace(10.0, 15.0)
    state = law.begin(own)
    for tick in range(1, 30):
        own = LanePlace(10.0 + tick, 15.0 + 1.5 * tick, tick % 5 == 0)
        (gamma_m, r_m, rate_mps) = inputs.point()
        status = LaneStatus(gamma_m, r_m, 0.1 * rate_mps, Mode.INLANE, tick % 4 == 0, 6, 30.0)
        other = inputs.kept(LaneNeighbour(2, own.t_s - 3.0, status, own.t_s, inputs.point(), inputs.point()))
        correction_mps, state = law.step(law.hear(state, own, other), own, (other,))
        assert abs(correction_mps) <= params.correction_max_mps
        outputs.append((correction_mps, state, law.reference_m(state, own)))
        outputs.append(law.predicted_m(status, own.t_s - 3.0, own.t_s))
    return outputs


def _use_navigation(module, params, inputs):
    first, second = (module.Navigation(params, 3, 1, PERIOD_S) for _ in range(2))
    truths = [VehicleState(tick, inputs.point(), inputs.attitude(), inputs.six(1.0)) for tick in range(20)]
    measured = [first.measured(truth) for truth in truths]
    assert [second.measured(truth) for truth in truths] == measured
    assert [state.tick for state in measured] == list(range(20))
    assert all(state.position_sd_m >= 0.0 and state.heading_sd_rad >= 0.0 for state in measured)
    # What odometry and tf say of it.
    assert len(first.odom_frame) == 3
    assert min(first.depth_sd_m, *first.velocity_sd_mps) >= 0.0
    stated = [(state.position_sd_m, state.heading_sd_rad) for state in measured]
    return [[(state.position, state.attitude, state.nu) for state in measured], stated]


def _use_sonar(module, params, inputs):
    sonar = module.Sonar(params, 3)
    outputs = [(0.0, 0.0, 0.0)]
    for tick in range(50):
        states = [VehicleState(tick, point, inputs.attitude(), inputs.six(1.0)) for point in inputs.points(4)]
        for address in range(1, 5):
            contacts = sonar.contacts(address, tick, PERIOD_S, tuple(states), tuple(inputs.points(2)))
            assert len(contacts) <= 5
            assert all(contact.range_m >= 0.0 for contact in contacts)
            outputs += contacts
    return outputs


def _use_obstacle_motion(module, params, _inputs):
    motion = module.Motion(params)
    times_s = [0.1 * tick for tick in range(3000)]
    offsets = [motion.offset(t_s) for t_s in times_s]
    assert offsets[0] == (0.0, 0.0, 0.0)
    assert [motion.offset(t_s) for t_s in reversed(times_s)] == offsets[::-1], "only the time may matter"
    steps_m = [distance(a, b) for a, b in itertools.pairwise(offsets)]
    assert max(steps_m) < 1.0, "an obstacle does not jump"
    return offsets


def _use_current(module, params, _inputs):
    current, other = (module.Current(params, MEAN_NED_MPS, 3, 1, PERIOD_S) for _ in range(2))
    ticks = range(0, 900, 3)
    velocities = [current.at(tick) for tick in ticks]
    assert [other.at(tick) for tick in reversed(ticks)] == velocities[::-1], "only the tick may matter"
    away_mps = [distance(velocity, MEAN_NED_MPS) for velocity in velocities]
    assert sum(away > current.varies_by_mps + 1e-12 for away in away_mps) < 0.05 * len(ticks)
    return [*itertools.chain(*velocities), current.varies_by_mps]


def _use_tracker(module, params, inputs):
    tracker, known = module.Tracker(params, ((30.0, 0.0, 0.0),)), inputs.point()
    nav = VehicleState(0, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)
    nobody = np.empty((0, 3)), np.empty((0, 3, 3)), np.empty(0, dtype=bool)
    outputs: list[object] = [(0.0, 0.0, 0.0)]
    for tick in range(20):
        t_s = 0.5 * tick
        rivals = tracker.rivals(t_s)
        seen = sighting(t_s, nav, contact_of(known), 0.1, 0.02)
        rows = [k for k, point in enumerate(rivals.points) if distance(tuple(point), known) < 1.0]
        claimed, unclaimed = ([(seen, rows[0])], []) if rows else ([], [seen])
        tracker.observe(t_s, Leftovers(claimed, unclaimed, *nobody))
        for each in tracker.obstacles(t_s):
            outputs += [each.position, each.velocity, each.sigma_m, each.age_s]
    return outputs


def _use_propagation(module, params, inputs):
    propagation = _made_propagation(module, params)
    places = [(inputs.point(), inputs.point(1000.0)) for _ in range(10)]
    places.append((places[0][0], places[0][0]))
    delays = [propagation.delay_s(*pair) for pair in places]
    losses = [propagation.loss_db(*pair, khz) for pair in places for khz in (0.5, 25.0)]
    assert min(delays) >= 0.0
    assert min(losses) >= 0.0
    assert delays[-1] == 0.0
    return delays + losses


def _made_propagation(module, params):
    try:
        return module.Propagation(params)
    except ValueError as error:
        if not str(error).startswith("propagation.kind: "):
            raise
        pytest.skip("what this propagation calls is not installed")


def _use_modem(module, params, _inputs):
    modem = module.Modem(params)
    airtimes = [modem.airtime_s(size) for size in (1, 32)]
    assert 0.0 <= modem.preamble_s <= airtimes[0] <= airtimes[1]
    assert modem.max_range_m > 0.0
    assert modem.max_payload_bytes >= 32
    assert isinstance(modem.captures, bool)
    if not isinstance(modem, LevelModem):
        return airtimes
    losses_db = (0.0, 60.0, 90.0, 120.0, 1000.0, 1e5)
    snrs = [modem.snr_ratio(loss_db) for loss_db in losses_db]
    assert snrs == sorted(snrs, reverse=True)
    heard = [modem.acquires(snr) for snr in snrs]
    assert heard == sorted(heard, reverse=True)
    assert heard[0]
    assert not heard[-1]
    logs = [modem.log_success(snr, 32) for snr in snrs]
    assert logs == sorted(logs, reverse=True)
    assert logs[-1] < math.log(1e-3)
    assert logs[0] <= 0.0
    assert all(modem.log_success(snr, 64) <= log for snr, log in zip(snrs, logs, strict=True))
    return [*airtimes, *snrs, *logs]


def _use_mac(module, params, _inputs):
    mac, other = module.Mac(params, 4, 7), module.Mac(params, 4, 7)
    mac.check(1e-3)
    asked = [(address, tick, PERIOD_S) for tick in range(300) for address in range(1, 5)]
    starts = [mac.opportunity_s(*question) for question in asked]
    assert [other.opportunity_s(*question) for question in reversed(asked)] == starts[::-1]
    for (_, tick, _), start_s in zip(asked, starts, strict=True):
        assert start_s is None or tick * PERIOD_S - 1e-8 <= start_s < (tick + 1) * PERIOD_S
    assert all(any(start_s is not None for start_s in starts[address::4]) for address in range(4))
    waits = (
        [mac.backoff_s(2, 5, attempt) for attempt in range(1, 9)] if isinstance(mac, SensingAccess) else []
    )
    assert all(wait_s > 0.0 for wait_s in waits)
    return [start_s for start_s in starts if start_s is not None] + waits


def _use_outage(module, params, _inputs):
    first, second = module.Outage(params, 1), module.Outage(params, 1)
    events = [(source, 3 - source, sequence) for source in (1, 2) for sequence in range(1, 50)]
    forward = [first.lost(*event) for event in events]
    assert [second.lost(*event) for event in reversed(events)] == forward[::-1], "only the event may matter"
    return [float(lost) for lost in forward]


class Role(NamedTuple):
    """The class of a plugin folder, its protocols, what it takes beside its params, and its use."""

    name: str
    contracts: tuple[type, ...]
    arguments: tuple[object, ...]
    use: Callable[..., list[object]]


ROLES = {
    "auv_core.models": Role("Model", (VehicleModel,), (), _fly_model),
    "auv_control.allocation": Role("Allocator", (ThrusterAllocator,), (PAIR,), _use_allocator),
    "auv_control.controllers": Role(
        "Controller", (MotionLaw, VelocityController, CourseController), (PERIOD_S,), _use_controller
    ),
    "auv_control.courses": Role("Course", (CourseLaw,), (PERIOD_S,), _use_course),
    "auv_control.references": Role("Reference", (ReferencePath,), (), _follow_reference),
    "auv_control.guidance.paths": Role("Path", (GuidancePath,), (), _follow_guidance_path),
    "auv_control.guidance.crab": Role("Crab", (CrabLaw,), (PERIOD_S,), _use_crab),
    "auv_flocking.fleets": Role(
        "Fleet",
        (FleetTask,),
        (
            Member(address=2, fleet_size=3),
            autopilot.Controller(autopilot.Params(), PERIOD_S),
            PERIOD_S,
            Mission(cycle_s=6.0),
        ),
        _use_fleet,
    ),
    "auv_flocking.flocking": Role(
        "Flocking", (FlockingLaw,), (SEPARATION, Member(is_leader=True)), _use_flocking
    ),
    "auv_flocking.separation": Role("Separation", (SeparationLaw,), (), _use_separation),
    "auv_flocking.consensus": Role("Consensus", (ConsensusFilter,), (4,), _use_consensus),
    "auv_flocking.coordination": Role("Coordination", (CoordinationLaw,), (PACE,), _use_coordination),
    "auv_flocking.estimators": Role("Estimator", (NeighbourEstimator,), (), _use_estimator),
    "auv_flocking.reports": Role("Format", (ReportFormat,), ((),), _use_format),
    "auv_flocking.trackers": Role("Tracker", (ObstacleTracker,), ((),), _use_tracker),
    "auv_sim.currents": Role("Current", (WaterCurrent,), (MEAN_NED_MPS, 3, 1, PERIOD_S), _use_current),
    "auv_sim.obstacles": Role("Motion", (ObstacleMotion,), (), _use_obstacle_motion),
    "auv_sim.navigation": Role("Navigation", (OwnNavigation,), (3, 1, PERIOD_S), _use_navigation),
    "auv_sim.acoustics.propagation": Role("Propagation", (SoundPropagation,), (), _use_propagation),
    "auv_sim.acoustics.modem": Role("Modem", (AcousticModem,), (), _use_modem),
    "auv_sim.acoustics.mac": Role("Mac", (MediumAccess,), (4, 7), _use_mac),
    "auv_sim.acoustics.outage": Role("Outage", (PacketLoss,), (1,), _use_outage),
    "auv_sim.acoustics.sonar": Role("Sonar", (HullSonar,), (3,), _use_sonar),
}
FOUND = [(folder, kind) for folder in ROLES for kind in list_plugins(folder)]
every_plugin = pytest.mark.parametrize(("folder", "kind"), FOUND, ids=[f"{f}.{k}" for f, k in FOUND])


def _presets(package):
    return sorted((Path(str(importlib.import_module(package).__file__)).parent / "presets").glob("*.yaml"))


def _params(folder, kind):
    """Return the params of a plugin, by name: its defaults, where it has them, and its presets."""
    cls = find_plugin(folder, kind).Params
    found = {}
    if all(field.default is not MISSING for field in fields(cls)):
        found["defaults"] = load(cls, {}, kind)
    for path in _presets(folder):
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
        if raw["kind"] == kind:
            found[path.stem] = load_section(raw, path.stem, folder).params
    assert found, f"{kind} has neither defaults nor a preset"
    return found


def _flat(value):
    if isinstance(value, tuple | list):
        return [number for item in value for number in _flat(item)]
    return [value]


def test_every_folder_has_plugins():
    assert {folder for folder, _ in FOUND} == set(ROLES)


@every_plugin
def test_params_come_from_defaults_or_a_preset_and_survive_dump_and_load(folder, kind):
    for params in _params(folder, kind).values():
        assert load(type(params), dump(params), kind) == params


@every_plugin
def test_unknown_keys_are_refused(folder, kind):
    with pytest.raises(ConfigError, match=r"^x\.params: unknown key 'no_such_key'; allowed: \["):
        load_section({"kind": kind, "params": {"no_such_key": 1}}, "x", folder)


@every_plugin
def test_the_class_of_the_role_and_everything_public_are_documented(folder, kind):
    module = find_plugin(folder, kind)
    made = getattr(module, ROLES[folder].name)
    documented = [module, module.Params, made]
    documented += [
        member for name, member in inspect.getmembers(made, inspect.isfunction) if not name.startswith("_")
    ]
    for thing in documented:
        assert inspect.getdoc(thing), thing
    for field in fields(module.Params):
        assert field.metadata["doc"], f"{kind}.{field.name}"


DEFAULTS = {
    "auv_control.controllers": {"constrained"},
    "auv_core.models": {"actuators", "adrift", "longest_step_s", "resting_command", "turn_radius_m"},
    "auv_flocking.fleets": {"reach"},
    "auv_flocking.flocking": {"is_staying"},
    "auv_control.guidance.paths": {"engage", "follow", "point"},
}
"""Members, by folder, that a protocol itself defines for the plugins that need no other."""


@every_plugin
def test_a_plugin_has_all_that_its_protocols_ask_for_by_itself(folder, kind):
    """It inherits them, so that mypy compares signatures; nothing is left to the empty body of a protocol."""
    module, role = find_plugin(folder, kind), ROLES[folder]
    cls = getattr(module, role.name)
    contracts = [base for base in cls.__mro__ if getattr(base, "_is_protocol", False)]
    assert all(base.__module__ == folder for base in contracts if base not in (Protocol, Generic))
    assert set(role.contracts) & set(contracts)
    params = next(iter(_params(folder, kind).values()))
    thing = _made_propagation(module, params) if role.name == "Propagation" else cls(params, *role.arguments)
    for name in set(members(cls)) - DEFAULTS.get(folder, set()):
        found = inspect.getattr_static(thing, name)
        assert not any(name in vars(base) and vars(base)[name] is found for base in contracts), name


def test_a_plugin_that_lacks_something_is_refused_in_one_line():
    class Modem:
        max_payload_bytes, preamble_s, captures = 32, 0.0, True

    with pytest.raises(ConfigError) as error:
        fulfilled(Modem(), AcousticModem)
    assert str(error.value) == (
        f"{__name__}: Modem has no airtime_s, max_range_m; "
        "allowed: a class with all members of auv_sim.acoustics.modem.AcousticModem"
    )


@every_plugin
def test_params_cannot_be_changed(folder, kind):
    assert find_plugin(folder, kind).Params.__dataclass_params__.frozen


@every_plugin
def test_outputs_are_finite_and_inputs_left_alone(folder, kind):
    use = ROLES[folder].use
    for params in _params(folder, kind).values():
        inputs = _Inputs()
        outputs = _flat(use(find_plugin(folder, kind), params, inputs))
        assert outputs
        assert np.isfinite(outputs).all()
        assert all(type(number) is float for number in outputs), (
            "plain floats, which travel and compare exactly"
        )
        inputs.assert_unchanged()


@every_plugin
def test_the_same_calls_give_the_same_outputs_to_the_last_bit(folder, kind):
    use = ROLES[folder].use
    for params in _params(folder, kind).values():
        first, second = (use(find_plugin(folder, kind), params, _Inputs()) for _ in range(2))
        assert repr(first) == repr(second)


@pytest.mark.parametrize("path", _presets("auv_sim.acoustics"), ids=lambda path: path.stem)
def test_every_preset_of_the_water_names_all_four_parts(path):
    raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert set(raw) == {"propagation", "modem", "mac", "outage"}
    for part, section in raw.items():
        load_section(section, part, f"auv_sim.acoustics.{part}")
