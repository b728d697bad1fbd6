"""
The modes of a vehicle in a fleet of lanes, as one pure function of named inputs.

    TRANSIT -> INLANE   in the lane and aligned with it for some seconds
    INLANE -> FORM      every neighbour is ready (see `is_ready`), and the fleet is heard
    FORM, INLANE -> LEAVE    the fleet has been silent for `lost_s`, or the path has ended
    LEAVE -> LOITER     settled in the layer
    LEAVE -> INLANE, LOITER -> TRANSIT    a packet was received, and the path goes on
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from auv_core.params import param
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus, Mode

IN_LANE = (Mode.INLANE, Mode.FORM, Mode.LEAVE)
"""Modes in which a vehicle flies in its lane, and is coordinated."""


@dataclass(frozen=True)
class Params:
    """When a vehicle changes its mode."""

    in_lane_m: float = param("cross-track error of a vehicle in its lane (m)", default=3.0, above=0.0)
    aligned_rad: float = param("course error of an aligned vehicle (rad)", default=0.6, above=0.0)
    aligned_s: float = param("how long it must be in its lane and aligned (s)", default=5.0, minimum=0.0)
    together_m: float = param(
        "largest difference of path parameters at which vehicles go into formation (m)",
        default=10.0,
        above=0.0,
    )
    coordinated_m: float = param(
        "cross-track error up to which a vehicle in its lane changes its speed for the others (m)",
        default=10.0,
        above=0.0,
    )
    lost_s: float = param(
        "silence of the whole fleet after which a vehicle leaves its slot (s)", default=300.0, above=0.0
    )
    lost_cycles: float = param("least value of lost_s, in cycles of the channel", default=8.0, minimum=0.0)
    settle_s: float = param(
        "least time in the lane before a vehicle that has left its slot loiters (s)",
        default=120.0,
        minimum=0.0,
    )
    settled_m: float = param("depth error of a vehicle that is in its layer (m)", default=1.5, above=0.0)

    def silence_max_s(self, cycle_s: float) -> float:
        """Return the silence after which a vehicle leaves its slot (s), for a cycle of the channel (s)."""
        return max(self.lost_s, self.lost_cycles * cycle_s)


class ModeState(NamedTuple):
    """The mode, since when it holds (s), and since when the vehicle is aligned in its lane (s; inf: not)."""

    mode: Mode
    since_s: float
    aligned_since_s: float = math.inf


class ModeInputs(NamedTuple):
    """
    What the mode depends on.

    t_s : time (s).
    cross_track_m : cross-track error of the own lane (m).
    course_error_rad : course over ground minus course of the lane (rad).
    layer_error_m : depth minus depth of the own layer (m).
    silence_s : time since any vehicle of the fleet was heard (s; 0 in a fleet of one).
    is_heard : whether the fleet is heard often enough to go into formation.
    are_ready : whether every neighbour is ready.
    has_ended : whether the vehicle is beyond the end of an open path.
    """

    t_s: float
    cross_track_m: float
    course_error_rad: float
    layer_error_m: float
    silence_s: float
    is_heard: bool
    are_ready: bool
    has_ended: bool = False


def next_mode(state: ModeState, inputs: ModeInputs, params: Params, cycle_s: float) -> ModeState:
    """Return the mode after a control period; at most one change per period."""
    is_aligned = (
        state.mode is not Mode.LOITER
        and abs(inputs.cross_track_m) < params.in_lane_m
        and abs(inputs.course_error_rad) < params.aligned_rad
    )
    aligned_since_s = min(state.aligned_since_s, inputs.t_s) if is_aligned else math.inf
    mode = _mode(state, inputs, aligned_since_s, params, params.silence_max_s(cycle_s))
    since_s = state.since_s if mode is state.mode else inputs.t_s
    return ModeState(mode, since_s, aligned_since_s)


def _mode(
    state: ModeState, inputs: ModeInputs, aligned_since_s: float, params: Params, silence_max_s: float
) -> Mode:
    leaves = inputs.silence_s > silence_max_s or inputs.has_ended
    if state.mode is Mode.TRANSIT:
        return Mode.INLANE if inputs.t_s - aligned_since_s >= params.aligned_s else Mode.TRANSIT
    if state.mode is Mode.LEAVE:
        is_settled = (
            inputs.t_s - state.since_s >= params.settle_s and abs(inputs.layer_error_m) < params.settled_m
        )
        if not leaves:
            return Mode.INLANE
        return Mode.LOITER if is_settled else Mode.LEAVE
    if state.mode is Mode.LOITER:
        return Mode.LOITER if leaves else Mode.TRANSIT
    if leaves:
        return Mode.LEAVE
    if state.mode is Mode.INLANE and inputs.is_heard and inputs.are_ready:
        return Mode.FORM
    return state.mode


def is_heard(silence_s: float, cycle_s: float) -> bool:
    """Return whether the fleet was heard within two cycles and 10 s."""
    return silence_s <= 2.0 * cycle_s + 10.0


def silent_s(cycle_s: float) -> float:
    """Return the silence of a neighbour after which it blocks no other (s)."""
    return 3.0 * cycle_s + 60.0


def is_ready(status: LaneStatus, ahead_m: float, params: Params) -> bool:
    """Return whether a neighbour is in its lane, and not far ahead or astern (m)."""
    return status.mode in (Mode.INLANE, Mode.FORM) and abs(ahead_m) < params.together_m


def are_ready(
    ahead_m: Iterable[tuple[LaneNeighbour, float]],
    fleet_size: int,
    t_s: float,
    params: Params,
    cycle_s: float,
) -> bool:
    """
    Return whether every neighbour is ready, or has been silent for so many cycles that it blocks no other.

    Deviation: a neighbour that was never heard counts as silent since 0 s, so that one that is lost at the
    start does not keep the others from their formation.

    Parameters
    ----------
    ahead_m : iterable of (LaneNeighbour, float)
        The neighbours heard so far, each with the own path parameter minus its predicted one (m).
    fleet_size : int
        Number of vehicles.
    t_s : float
        Time (s).
    params : Params
        Of the modes.
    cycle_s : float
        Cycle of the channel (s).

    """
    heard, allowed_s = 0, silent_s(cycle_s)
    for other, distance_m in ahead_m:
        heard += 1
        if t_s - other.time_s <= allowed_s and not is_ready(other.status, distance_m, params):
            return False
    return heard == fleet_size - 1 or t_s > allowed_s
