"""
The task of a vehicle that cannot stop in a fleet of lanes: cooperative path following.

In every control period: where the lane is (line of sight), which mode (`lanes.modes`), which speed
(`coordination`), and the fins and propeller for them (the controller). Outside its lane a vehicle runs at a
speed through the water, which is not measured: it follows from the propeller.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from auv_control.controllers import CourseController, VelocityReference
from auv_control.courses import Guided
from auv_control.guidance.autopilots import Setpoint
from auv_control.guidance.crab import make_crab
from auv_control.guidance.feasibility import Turning, check_lane
from auv_control.guidance.line_of_sight import Sight, over_ground
from auv_control.guidance.path_guide import PathGuide
from auv_control.guidance.paths import circle, make_path
from auv_core.geometry import Box, Vec3, clipped
from auv_core.integrate import State
from auv_core.messages import FinCommand, VehicleState
from auv_flocking.coordination import LanePlace, Pace, make_coordination
from auv_flocking.fleets import FleetTask, Mission
from auv_flocking.fleets._lane_checks import check_member, lane_reach
from auv_flocking.fleets._lane_settings import Params as Params
from auv_flocking.flocking import NOTHING_HEARD, Member
from auv_flocking.lanes.broadcast import Sent, after_slot
from auv_flocking.lanes.keeping_up import KeepingUp, kept_up
from auv_flocking.lanes.modes import IN_LANE, ModeInputs, ModeState, are_ready, is_heard, next_mode
from auv_flocking.lanes.moves import check_move, spare_of
from auv_flocking.lanes.plan import planned
from auv_flocking.lanes.status import FIELDS, STRAIGHT_ON, LaneNeighbour, LaneStatus, Mode, apart_m, neighbour
from auv_flocking.lanes.turn_away import Intent, TurnAway
from auv_flocking.neighbours.estimates import TIME, Estimates, Neighbours

MODE, GAMMA, REFERENCE, CORRECTION, TURN_AWAY_COURSE = 5, 6, 7, 8, 9
"""Columns of `law_state` after those of a course."""


class Fleet(FleetTask):
    """
    The task of one vehicle.

    Parameters
    ----------
    params : Params
        Of the fleet, the same for all vehicles.
    member : Member
        The vehicle's address and the size of the fleet.
    controller : CourseController
        The autopilots.
    period_s : float
        Control period (s).
    mission : Mission
        Where the vehicles start, for turning away before their first packets, and the channel's cycle.

    After a step: `law_state` (heading (rad), turn rate (rad/s), depth (m) and speed (m/s) that it asks for,
    cross-track error (m), mode, gamma and reference r (m), correction (m/s), course of turning away, then the
    state of the autopilots), `sight` (what guidance found), `mode`, `gamma_m` (path parameter minus the
    slot's offset, m), `correction_mps` (of the coordination law) and `status` (what a packet says). `layer_m`
    is the depth of the own layer (m).

    """

    shared_fields = FIELDS
    flock_velocity = NOTHING_HEARD
    centre_rate: Vec3 = (0.0, 0.0, 0.0)
    sight: Sight
    status: LaneStatus

    def __init__(
        self,
        params: Params,
        member: Member,
        controller: CourseController,
        period_s: float,
        mission: Mission,
    ) -> None:
        self._params, self._member, self._period_s = params, member, period_s
        self._cycle_s = params.channel_cycle_s(mission)
        slots, layers_m = params.slots(member.fleet_size), params.layer_depths(member.fleet_size)
        self._way, self.layer_m = (
            params.ways(member.fleet_size)[member.address - 1],
            layers_m[member.address - 1],
        )
        self._slot = self._way.at(0.0)
        self._controller = controller
        self.safe_command = controller.safe_command
        self.law_state: tuple[float, ...] = ()
        self.centre: Vec3 = (0.0, 0.0, 0.0)
        self.reference = VelocityReference((0.0, 0.0, 0.0), 0.0)
        self._path = make_path(params.path)
        self._loiter = circle.Path(
            circle.Params(params.loiter_north_m, params.loiter_east_m, params.loiter_radius_m)
        )
        self._guide = PathGuide(self._path, make_crab(params.crab, period_s))
        track = self._path.track
        self._pace = Pace(params.speed_mps, track.round_m, period_s)
        self._law = make_coordination(params.coordination, self._pace)
        self._coordination: State | None = None
        self._keeping_up = KeepingUp()
        self._others: dict[int, LaneNeighbour] = {}
        self._newest_s = 0.0
        self._heard: Sequence[tuple[float, ...]] = ()
        self._sent: Sent | None = None
        self._turn_away, self._plan = None, {}
        if params.turn_away.kind != "none":
            self._turn_away = TurnAway(params.turn_away, track, slots, member.address, params.speed_mps)
            plan = planned(mission.starts, track, slots, layers_m)
            self._plan = {other.address: other for other in plan if other.address != member.address}
        self.mode = ModeState(Mode.TRANSIT, 0.0)
        self.gamma_m = 0.0
        self.correction_mps = 0.0

    def step(
        self, t_s: float, nav: VehicleState, neighbours: Neighbours, others: Neighbours = ()
    ) -> FinCommand:
        """
        Return the command of one control period.

        Parameters
        ----------
        t_s : float
            Scenario time (s).
        nav : VehicleState
            The vehicle's own navigation.
        neighbours : sequence of NeighbourEstimate
            The neighbours, whose shared numbers are those of `LaneStatus`.
        others : sequence of NeighbourEstimate
            Vehicles with another task, from which a vehicle on its way to its lane turns away.

        """
        loiters = self.mode.mode is Mode.LOITER
        self._slot = slot = self._way.at(t_s)
        self.sight = found = self._guide.look(nav, 0.0 if loiters else slot.position[1])
        before_m = self.gamma_m
        if not loiters:
            self.gamma_m = self._guide.s_m - slot.position[0]
            found = _across(found, slot.velocity[1], self._params.speed_mps)
        own = LanePlace(t_s, self.gamma_m, self._keeping_up.is_limited)
        fresh = self._hear(own, neighbours)
        self.mode = self._next_mode(t_s, nav)
        speed_mps = self._coordinated_mps(own, found, fresh, self.gamma_m - before_m)
        if self._turn_away is not None:
            found = self._turned_away(t_s, nav, found, self._turn_away, others)
        self.status = self._status(own)
        self._guide.change_to(self._loiter if self.mode.mode is Mode.LOITER else self._path)
        setpoint = Setpoint(found.heading_rad, found.turn_rate_radps, self.status.depth_target_m, speed_mps)
        along_mps = found.along_mps if self.mode.mode in IN_LANE else speed_mps
        command = self._controller.step(nav, Guided(setpoint, along_mps, found.cross_track_m))
        self._note(nav, setpoint)
        return command

    def _note(self, nav: VehicleState, setpoint: Setpoint) -> None:
        """Keep what a recording shows of this step."""
        c, s = math.cos(setpoint.heading_rad), math.sin(setpoint.heading_rad)
        velocity = (setpoint.speed_mps * c, setpoint.speed_mps * s, 0.0)
        self.reference = VelocityReference(velocity, setpoint.heading_rad)
        self.centre = nav.position
        status = self.status
        self.law_state = (
            *setpoint,
            self.sight.cross_track_m,
            float(status.mode),
            status.gamma_m,
            status.reference_m,
            self.correction_mps,
            float(status.turn_away_course),
            *self._controller.state,
        )

    @property
    def round_m(self) -> float:
        """Length of a round of the path (m; 0: it is open)."""
        return self._pace.round_m

    def check(self, vehicle: Turning, current_mps: float) -> None:
        """Raise ValueError unless the vehicle can fly its lane in a current of any direction (m/s)."""
        p, way = self._params, self._way
        check_member(vehicle, p, self._member.fleet_size, current_mps)
        for slot in dict.fromkeys((way.before, way.after)):
            check_lane(vehicle, self._path.track, slot[1], p.speed_mps, current_mps)
        check_move(way, spare_of(p.speed_mps, p.least_speed_mps, p.largest_speed_mps))

    def reach(self) -> Box:
        """Return a box around the lane and the circle to loiter on, from slot to layer (m; NED)."""
        slots = (self._way.before, self._way.after)
        lane_m = max(abs(slot[1]) for slot in slots)
        depths_m = (*(self._params.depth_m + slot[2] for slot in slots), self.layer_m)
        return lane_reach(self._path.track, lane_m, self._loiter.track, depths_m)

    def shared(self) -> tuple[float, ...]:
        """Return the numbers that this task adds to a packet after a step."""
        return self.status.numbers()

    def sends(self, t_s: float) -> bool:
        """Return whether the vehicle uses an own slot of the channel at `t_s` (s), after a step."""
        ahead_m = 0.0
        if self._sent is not None:
            predicted_m = self._law.predicted_m(self._sent.status, self._sent.time_s, t_s)
            ahead_m = apart_m(self.gamma_m, predicted_m, self._pace.round_m)
        is_sent, self._sent = after_slot(t_s, self.status, ahead_m, self._sent, self._params.broadcast)
        return is_sent

    def _reference_m(self, own: LanePlace) -> float:
        if self._coordination is None:
            return own.gamma_m - self._pace.speed_mps * own.t_s
        return self._law.reference_m(self._coordination, own)

    def _hear(self, own: LanePlace, neighbours: Neighbours) -> list[LaneNeighbour]:
        """
        Return the neighbours with a new packet, in the order of addresses.

        Estimates keep their list of shared numbers until a packet comes.
        """
        estimates = Estimates.of(neighbours)
        if estimates.shared is self._heard:
            return []
        self._heard, fresh = estimates.shared, []
        times_s = estimates.column(TIME)
        for index, (address, time_s) in enumerate(zip(estimates.addresses, times_s, strict=True)):
            known = self._others.get(address)
            if estimates.shared[index] and (known is None or time_s > known.time_s):
                estimate = estimates[index]
                fresh.append(neighbour(estimate, own.t_s, own.gamma_m, self._reference_m(own)))
        if fresh:
            heard = {**self._others, **{other.address: other for other in fresh}}
            self._others = dict(sorted(heard.items()))
            self._newest_s = max(other.time_s for other in heard.values())
        return fresh

    def _next_mode(self, t_s: float, nav: VehicleState) -> ModeState:
        p, track = self._params, self._path.track
        silence_s = t_s - self._newest_s if self._member.fleet_size > 1 else 0.0
        inputs = ModeInputs(
            t_s,
            self.sight.cross_track_m,
            self.sight.course_error_rad,
            nav.position[2] - self.layer_m,
            silence_s,
            is_heard(silence_s, self._cycle_s),
            self.mode.mode is Mode.INLANE and self._are_ready(t_s),
            not track.is_closed and self.gamma_m >= track.length_m,
        )
        return next_mode(self.mode, inputs, p.modes, self._cycle_s)

    def _are_ready(self, t_s: float) -> bool:
        p = self._params
        ahead_m = [
            apart_m(
                self.gamma_m, other.status.gamma_m + p.speed_mps * (t_s - other.time_s), self._pace.round_m
            )
            for other in self._others.values()
        ]
        return are_ready(
            zip(self._others.values(), ahead_m, strict=True),
            self._member.fleet_size,
            t_s,
            p.modes,
            self._cycle_s,
        )

    def _coordinated_mps(
        self, own: LanePlace, found: Sight, fresh: list[LaneNeighbour], moved_m: float
    ) -> float:
        """Return the speed along the lane (m/s), after the law has heard the fresh packets."""
        p, law = self._params, self._law
        self.correction_mps = 0.0
        if self.mode.mode not in IN_LANE:
            self._coordination, self._keeping_up = None, KeepingUp()
            return p.transit_speed_mps
        if self._coordination is None:
            self._coordination = law.begin(own)
        for other in fresh:
            if other.status.mode in IN_LANE:
                self._coordination = law.hear(self._coordination, own, other)
        counted = [
            other
            for other in self._others.values()
            if other.status.mode in IN_LANE and own.t_s - other.time_s <= p.remembered_s
        ]
        correction_mps, self._coordination = law.step(self._coordination, own, counted)
        ratio = 1.0 - self._guide.curvature_pm * self._slot.position[1]
        is_aligned = (
            abs(found.course_error_rad) < p.modes.aligned_rad
            and abs(found.cross_track_m) < p.modes.coordinated_m
        )
        if is_aligned:
            self.correction_mps = correction_mps
        asked_mps = ratio * (p.speed_mps + self.correction_mps + self._slot.velocity[0])
        speed_mps = min(max(asked_mps, p.least_speed_mps), p.largest_speed_mps)
        if is_aligned:
            self._keeping_up = kept_up(
                self._keeping_up,
                speed_mps - found.along_mps,
                moved_m / self._period_s - p.speed_mps,
                self._period_s,
                p.keeping_up,
            )
        return speed_mps

    def _turned_away(
        self, t_s: float, nav: VehicleState, found: Sight, law: TurnAway, others: Neighbours
    ) -> Sight:
        """Return what guidance found, with the heading of a vehicle in transit that turns away."""
        if self.mode.mode is not Mode.TRANSIT:
            law.give_up()
            return found
        own = over_ground(nav)
        intent = Intent(
            *nav.position,
            own.course_rad,
            own.speed_mps,
            self._guide.s_m,
            self._slot.position[1],
            self.layer_m,
            0.0,
            0.0,
        )
        known = {**self._plan, **self._others}
        offset_rad = law.decide(t_s, intent, known.values(), others)
        if law.course == STRAIGHT_ON:
            return found
        return found._replace(heading_rad=found.heading_rad + offset_rad, turn_rate_radps=0.0)

    def _status(self, own: LanePlace) -> LaneStatus:
        depth_m = self.layer_m
        if self.mode.mode is Mode.FORM:
            depth_m = self._params.depth_m + self._slot.position[2]
        return LaneStatus(
            own.gamma_m,
            self._reference_m(own),
            clipped(self._keeping_up.rate_mps, 1.27),
            self.mode.mode,
            self._keeping_up.is_limited,
            self._turn_away.course if self._turn_away else STRAIGHT_ON,
            depth_m,
        )


def _across(found: Sight, across_mps: float, along_mps: float) -> Sight:
    """Return what guidance found, with the heading of a lane that moves to starboard (m/s)."""
    if across_mps == 0.0:
        return found
    return found._replace(heading_rad=found.heading_rad + math.atan2(across_mps, along_mps))
