"""The settings of a fleet of lanes: the path, the formation on it, and the parts of the task."""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.formations.shapes import NO_SHAPE, SHAPES, shape_slots
from auv_control.formations.switching import Transition
from auv_control.guidance.crab import measured as measured_crab
from auv_control.guidance.paths import racetrack
from auv_core.geometry import Vec3
from auv_core.params import Section, param
from auv_flocking.coordination import reference_consensus
from auv_flocking.fleets import Mission
from auv_flocking.lanes import broadcast, keeping_up, modes, turn_away
from auv_flocking.lanes.layers import check_layers, layer_depths, staggered
from auv_flocking.lanes.moves import ways

_CYCLE_TOLERANCE_S = 1e-6
_RACETRACK = Section("racetrack", racetrack.Params())
_MEASURED = Section("measured", measured_crab.Params())
_REFERENCE_CONSENSUS = Section("reference_consensus", reference_consensus.Params())


@dataclass(frozen=True)
class Params:
    """The path, the formation on it, and the parts of the task."""

    path: Section = param("path of the fleet", default=_RACETRACK, plugins="auv_control.guidance.paths")
    crab: Section = param("crab law of guidance", default=_MEASURED, plugins="auv_control.guidance.crab")
    coordination: Section = param(
        "law of coordination", default=_REFERENCE_CONSENSUS, plugins="auv_flocking.coordination"
    )
    shape: str = param("shape of the formation", default="line", choices=SHAPES)
    spacing_m: float = param("distance of neighbouring slots (m)", default=15.0, above=0.0)
    stagger_m: float = param("difference of depth of the slots in one lane (m)", default=6.0, minimum=0.0)
    next_shape: str = param(
        "shape to switch to; none: the first one is kept", default=NO_SHAPE, choices=(*SHAPES, NO_SHAPE)
    )
    switch_at_s: float = param("scenario time of the switch (s)", default=0.0, minimum=0.0)
    move_s: float = param("time T_s of the move to the other shape (s)", default=300.0, above=0.0)
    speed_mps: float = param("speed v_L along the path (m/s)", default=1.5, above=0.0, maximum=10.0)
    least_speed_mps: float = param("least commanded speed over ground (m/s)", default=0.7, above=0.0)
    largest_speed_mps: float = param("largest commanded speed over ground (m/s)", default=2.4, above=0.0)
    transit_speed_mps: float = param("speed through the water outside the lane (m/s)", default=1.5, above=0.0)
    depth_m: float = param("depth of the formation (m)", default=30.0, above=0.0, maximum=500.0)
    layer_step_m: float = param("difference of depth between layers (m)", default=6.0, above=0.0)
    layers: str = param(
        "layers on both sides of the formation or only below it; none: all vehicles fly at its depth",
        default="both",
        choices=("both", "below", "none"),
    )
    loiter_north_m: float = param("centre of the circle to loiter on (m; NED north)", default=0.0)
    loiter_east_m: float = param("centre of the circle to loiter on (m; NED east)", default=0.0)
    loiter_radius_m: float = param("radius of that circle (m)", default=50.0, above=0.0)
    cycle_s: float | None = param(
        "cycle of the channel (s); null: that of acoustics.mac", default=None, above=0.0
    )
    remembered_s: float = param("age up to which a neighbour's packet is used (s)", default=400.0, above=0.0)
    modes: modes.Params = param("when the mode changes", default=modes.Params())
    broadcast: broadcast.Params = param("when to send", default=broadcast.Params())
    keeping_up: keeping_up.Params = param("when a vehicle cannot keep up", default=keeping_up.Params())
    turn_away: turn_away.Params = param(
        "turning away from others on the way to the lane", default=turn_away.Params()
    )

    def __post_init__(self) -> None:
        """Refuse speeds out of order, and a switch with a law that takes the lanes of others for fixed."""
        if self.least_speed_mps > self.largest_speed_mps:
            raise ValueError(
                f"least_speed_mps: {self.least_speed_mps!r} is not allowed; "
                f"allowed: at most largest_speed_mps, {self.largest_speed_mps!r}"
            )
        if self.next_shape != NO_SHAPE and self.turn_away.kind != "none":
            raise ValueError(
                f"next_shape: {self.next_shape!r} is not allowed with turn_away.kind "
                f"{self.turn_away.kind!r}; allowed: none, with which vehicles keep to layers of depth"
            )

    def slots(self, fleet_size: int) -> tuple[Vec3, ...]:
        """Return the offsets of all slots (m; along the course, to starboard, down)."""
        return self._slots_of(self.shape, fleet_size)

    def ways(self, fleet_size: int) -> tuple[Transition, ...]:
        """Return the way of each vehicle's slot; without a switch it stays where it is."""
        before = self.slots(fleet_size)
        if self.next_shape == NO_SHAPE:
            return tuple(Transition(slot, slot) for slot in before)
        after = self._slots_of(self.next_shape, fleet_size)
        return ways(before, after, self.switch_at_s, self.move_s)

    def _slots_of(self, shape: str, fleet_size: int) -> tuple[Vec3, ...]:
        return staggered(shape_slots(shape, fleet_size, self.spacing_m), self.stagger_m)

    def layer_depths(self, fleet_size: int) -> tuple[float, ...]:
        """
        Return the depth of each vehicle's layer (m).

        Raises
        ------
        ValueError
            If a vehicle would cross another one's slot in its layer, or a layer is above the surface.

        """
        all_ways = self.ways(fleet_size)
        if self.layers == "none":
            return tuple(self.depth_m for _ in all_ways)
        before, after = [way.before for way in all_ways], [way.after for way in all_ways]
        depths = layer_depths(
            before, self.depth_m, self.layer_step_m, also=after, only_below=self.layers == "below"
        )
        for slots in (before, after):
            check_layers(depths, slots, self.depth_m)
        return depths

    def channel_cycle_s(self, mission: Mission) -> float:
        """
        Return the cycle of the channel (s).

        Raises
        ------
        ValueError
            If it is given neither here nor by the medium access, or if they differ.

        """
        told_s = mission.cycle_s
        if self.cycle_s is None and told_s is None:
            raise ValueError("cycle_s: missing; allowed: a number, since acoustics.mac has no cycle")
        if (
            self.cycle_s is not None
            and told_s is not None
            and abs(self.cycle_s - told_s) > _CYCLE_TOLERANCE_S
        ):
            raise ValueError(
                f"cycle_s: {self.cycle_s!r} is not allowed; allowed: {told_s:g}, the cycle of acoustics.mac"
            )
        return self.cycle_s or told_s or 0.0
