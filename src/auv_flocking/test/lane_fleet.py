"""
A fleet of torpedoes in lanes, flown in process: vehicles, a TDMA channel with losses, and the lanes' task.

It needs no simulator: the water is a constant current, navigation is exact, a packet is on the air for 0.35 s
and travels at 1500 m/s, and each receiver loses it with the same probability.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from torpedo_flights import preset

from auv_control.controllers import autopilot
from auv_core.geometry import body_to_ned, heading_from_quaternion
from auv_core.messages import VehicleState
from auv_core.models import make_model
from auv_flocking.fleets import Mission, Start
from auv_flocking.fleets.lanes import Fleet, Params
from auv_flocking.flocking import Member
from auv_flocking.lanes.status import FIELDS, Mode
from auv_flocking.neighbours.estimates import NeighbourEstimate
from auv_flocking.report import Report
from auv_flocking.reports import lane

PERIOD_S, STEP_S, STEPS = 0.2, 0.1, 2
AIRTIME_S, SOUND_MPS = 0.35, 1500.0
CENTRE_M, REACH_M, APART_M, START_MPS = (100.0, 0.0), 100.0, 60.0, 1.5
SHALLOW_M = 5.0
EYE = np.eye(6)


@dataclass(frozen=True)
class Setting:
    """What is flown; `lost` are pairs of an address and the time at which it is lost (s)."""

    seed: int = 1000
    count: int = 5
    shape: str = "line"
    spacing_m: float = 15.0
    stagger_m: float = 6.0
    slot_s: float = 2.0
    loss_prob: float = 0.3
    current_mps: float = 0.3
    duration_s: float = 900.0
    start_at_one_depth: bool = False
    lost: tuple[tuple[int, float], ...] = ()
    silent_s: tuple[float, float] = (math.inf, math.inf)
    weak: tuple[int, ...] = ()
    weak_rpm: float = 806.0
    params: Params = field(default_factory=Params)


class Starts(NamedTuple):
    """Horizontal places (m; NED), headings (rad), and the direction of the current (rad)."""

    places: list[tuple[float, float]]
    headings_rad: list[float]
    current_rad: float


class Flown(NamedTuple):
    """Per period: time (s), positions (m; NED), gamma, cross-track error (m), mode; packet times (s)."""

    times_s: Any
    positions: Any
    gammas_m: Any
    cross_tracks_m: Any
    modes: Any
    sent_s: list[float]
    round_m: float


def autopilots():
    """Return the autopilots of a vehicle."""
    return autopilot.Controller(autopilot.Params(), PERIOD_S)


def random_starts(seed, count):
    """Return the starts of a seed: apart from each other, within a circle."""
    rng = np.random.default_rng(seed)
    places: list[tuple[float, float]] = []
    tries = 0
    while len(places) < count:
        north_m, east_m = rng.uniform(-REACH_M, REACH_M, 2).tolist()
        tries += 1
        if tries > 2000:
            places, tries = [], 0
        place = (CENTRE_M[0] + north_m, CENTRE_M[1] + east_m)
        if math.hypot(north_m, east_m) <= REACH_M and all(math.dist(place, p) >= APART_M for p in places):
            places.append(place)
    headings = rng.uniform(-math.pi, math.pi, count).tolist()
    return Starts(places, headings, float(rng.uniform(-math.pi, math.pi)))


class Torpedo:
    """One vehicle: hull, task, and what it has heard."""

    def __init__(self, model, state, task, address, most_rpm=math.inf):
        self.model, self.state, self.task, self.address = model, state, task, address
        self.most_rpm = most_rpm
        self.heard: dict[int, Report] = {}
        self.is_lost = False

    def nav(self, tick):
        """Return the exact navigation."""
        return VehicleState(tick, self.state[:3], self.state[3:7], self.state[7:13])

    def act(self, tick, current):
        """Fly one control period."""
        command = (0.0, 0.0, 0.0)
        if not self.is_lost:
            rudder, plane, rpm = self.task.step(
                tick * PERIOD_S, self.nav(tick), self.estimates(tick * PERIOD_S)
            )
            command = (rudder, plane, min(rpm, self.most_rpm))
        self.state = self.model.step(self.state, self.model.limited_command(command), current, STEP_S, STEPS)

    def estimates(self, t_s):
        """Return what the packets tell, at their time tags."""
        return [
            NeighbourEstimate(
                address, r.position, r.velocity, EYE, t_s - r.time_s, r.centre, r.flock_velocity,
                time_s=r.time_s, shared=r.shared, heading_rad=r.heading_rad,
            )
            for address, r in sorted(self.heard.items())
        ]  # fmt: skip

    def report(self, tick):
        """Return the report of this tick."""
        nav = self.nav(tick)
        velocity = body_to_ned(nav.attitude, nav.nu[:3])
        return Report(
            self.address, tick * PERIOD_S, nav.position, velocity, nav.position, (0.0, 0.0, 0.0),
            heading_rad=heading_from_quaternion(nav.attitude), shared=self.task.shared(),
        )  # fmt: skip


class Channel:
    """TDMA with one slot for every vehicle per cycle, and independent losses."""

    def __init__(self, setting, rng):
        self._setting, self._rng = setting, rng
        self._format = lane.Format(lane.Params(), FIELDS)
        self._on_air: list[tuple[float, Torpedo, Report]] = []
        self.sent_s: list[float] = []

    def deliver(self, t_s):
        """Hand over what has arrived."""
        for _, receiver, report in sorted(
            (each for each in self._on_air if each[0] <= t_s), key=lambda each: (each[0], each[1].address)
        ):
            known = receiver.heard.get(report.address)
            if known is None or report.time_s > known.time_s:
                receiver.heard[report.address] = report
        self._on_air = [each for each in self._on_air if each[0] > t_s]

    def slot(self, tick, fleet):
        """Let the vehicle send whose slot begins in this tick, if it wants to."""
        t_s, slot_s = tick * PERIOD_S, self._setting.slot_s
        number = math.floor(t_s / slot_s + 1e-9)
        if t_s - number * slot_s > PERIOD_S - 1e-9:
            return
        sender = fleet[number % len(fleet)]
        if sender.is_lost or not sender.task.sends(t_s):
            return
        self.sent_s.append(t_s)
        report = self._format.decode(self._format.encode(sender.report(tick)), t_s)
        first_s, last_s = self._setting.silent_s
        for receiver in fleet:
            is_received = self._rng.random() >= self._setting.loss_prob and not first_s <= t_s < last_s
            if receiver is not sender and is_received:
                way_m = math.dist(sender.state[:3], receiver.state[:3])
                self._on_air.append((t_s + AIRTIME_S + way_m / SOUND_MPS, receiver, report))


def mission_of(setting, starts, params):
    """Return where every vehicle starts, as the mission plan has it."""
    layers_m = params.layer_depths(setting.count)
    poses = zip(starts.places, starts.headings_rad, layers_m, strict=True)
    return Mission(
        tuple(
            Start((*place, SHALLOW_M if setting.start_at_one_depth else layer_m), heading_rad, START_MPS)
            for place, heading_rad, layer_m in poses
        ),
        setting.slot_s * setting.count,
    )


def fleet_of(setting, starts):
    """Return the vehicles of a setting at their starts."""
    params = replace(
        setting.params,
        shape=setting.shape,
        spacing_m=setting.spacing_m,
        stagger_m=setting.stagger_m,
    )
    model = make_model(preset("remus100"))
    mission = mission_of(setting, starts, params)
    fleet = []
    for address, start in enumerate(mission.starts, start=1):
        task = Fleet(params, Member(False, address, setting.count), autopilots(), PERIOD_S, mission)
        state = model.initial_state(*start)
        fleet.append(
            Torpedo(model, state, task, address, setting.weak_rpm if address in setting.weak else math.inf)
        )
    return fleet


def fly(setting):
    """Return a flight of a setting."""
    starts = random_starts(setting.seed, setting.count)
    fleet = fleet_of(setting, starts)
    current = (
        setting.current_mps * math.cos(starts.current_rad),
        setting.current_mps * math.sin(starts.current_rad),
        0.0,
    )
    channel = Channel(setting, np.random.default_rng([setting.seed, 1]))
    rows: list[tuple[Any, ...]] = []
    for tick in range(round(setting.duration_s / PERIOD_S)):
        t_s = tick * PERIOD_S
        for address, lost_s in setting.lost:
            torpedo = fleet[address - 1]
            if t_s >= lost_s and not torpedo.is_lost:
                torpedo.is_lost, torpedo.model = True, torpedo.model.adrift()
        channel.deliver(t_s)
        positions = [torpedo.state[:3] for torpedo in fleet]
        for torpedo in fleet:
            torpedo.act(tick, current)
        tasks = [torpedo.task for torpedo in fleet]
        rows.append(
            (
                t_s,
                positions,
                [task.gamma_m for task in tasks],
                [task.sight.cross_track_m for task in tasks],
                [task.mode.mode for task in tasks],
            )
        )
        channel.slot(tick, fleet)
    columns = tuple(np.array(column) for column in zip(*rows, strict=True))
    return Flown(
        columns[0], columns[1], columns[2], columns[3], columns[4], channel.sent_s, fleet[0].task.round_m
    )


def coordination_error_m(flown):
    """Return the largest difference of two path parameters in every period (m)."""
    differences = flown.gammas_m[:, :, None] - flown.gammas_m[:, None, :]
    differences -= flown.round_m * np.round(differences / flown.round_m)
    return np.abs(differences).max(axis=(1, 2))


def distances_m(flown, addresses=None):
    """Return the smallest distance of two vehicles in every period (m)."""
    rows = range(flown.positions.shape[1]) if addresses is None else [a - 1 for a in addresses]
    points = flown.positions[:, list(rows), :]
    away = np.linalg.norm(points[:, :, None] - points[:, None, :], axis=3)
    first, second = np.triu_indices(points.shape[1], 1)
    return away[:, first, second].min(axis=1)


def formed_s(flown):
    """Return from when on all vehicles are in formation (s; inf: never)."""
    formed = (flown.modes == Mode.FORM).all(axis=1)
    return float(flown.times_s[np.argmax(formed)]) if formed.any() else math.inf
