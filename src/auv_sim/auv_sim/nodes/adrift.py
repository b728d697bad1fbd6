"""The hulls of lost vehicles: they drift on while the run continues without their nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from visualization_msgs.msg import Marker

from auv_core.messages import VehicleState
from auv_core.models import make_model
from auv_msgs.msg import VehicleState as VehicleStateMsg
from auv_ros.run_config import TickClock
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.markers import LOST_HULL, hull_marker
from auv_sim.vehicle import Vehicle, VehicleConfig


class Adrift:
    """
    Moves and publishes hulls without a command, for the relay.

    Parameters
    ----------
    topics : Topics
        Of the relay; it gets the states of these hulls.
    hulls : mapping of int to VehicleConfig
        The hulls of vehicles that may be lost, by index of the vehicle.
    ticks : TickClock
        The time of the run.

    """

    def __init__(self, topics: Topics, hulls: Mapping[int, VehicleConfig], ticks: TickClock) -> None:
        write = convert.state_stencil().filled
        self._states = {
            index: topics.add(VehicleStateMsg, f"/{hull.vehicle_id}/state", write)
            for index, hull in hulls.items()
        }
        self._hulls = hulls
        self._ticks = ticks
        self._lost: dict[int, Vehicle] = {}

    def lose(self, index: int, state: VehicleState) -> None:
        """Let a hull drift on from a state."""
        hull = Vehicle(self._hulls[index])
        hull.restore(state)
        hull.lose_computer()
        self._lost[index] = hull

    def step(self, index: int) -> VehicleState:
        """Publish and return the next state of a hull."""
        state = self._lost[index].step(None)
        self._states[index].publish(self._ticks.stamp_s(state.tick), *convert.state_numbers(state))
        return state

    def markers(self, states: Sequence[VehicleState], t_s: float) -> list[Marker]:
        """Return the hulls that are lost, in these states of the fleet, at the time `t_s` (s)."""
        markers = []
        for index in sorted(self._lost):
            hull = self._hulls[index]
            handling, state = make_model(hull.model).handling, states[index]
            pose = (state.position, state.attitude)
            markers.append(hull_marker(hull.vehicle_id, t_s, pose, handling, LOST_HULL))
        return markers
