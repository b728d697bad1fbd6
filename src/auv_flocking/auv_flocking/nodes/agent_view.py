"""An agent's topics for people and tools: its estimates, its reference and its path."""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import Path
from visualization_msgs.msg import MarkerArray

from auv_core.geometry import Vec3
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.neighbours.estimates import CENTRE
from auv_msgs.msg import ControlStatus, FlockingCentre, NeighbourEstimates
from auv_ros.qos import LATCHED
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.markers import (
    MARKER_TICKS,
    SENSED,
    STANDING_MARKER_TICKS,
    lines,
    removed,
    sphere,
    sphere_stencil,
)

_PATH_POINTS = 120
_PATH_SPAN_S = 600.0


class AgentView:
    """
    The topics of an agent node that no other node of the run reads.

    Parameters
    ----------
    topics : Topics
        Of the node; it gets these.
    config : AgentConfig
        The agent's; its frames and markers begin with its name.
    agent : Agent
        The agent to show.

    """

    def __init__(self, topics: Topics, config: AgentConfig, agent: Agent) -> None:
        name = config.vehicle_id
        self._config, self._agent = config, agent
        self._reference = topics.add(TwistStamped, "reference", convert.velocity_stencil().filled)
        self._centre = topics.add(FlockingCentre, "flocking_centre", convert.centre_stencil().filled)
        self._control = topics.add(ControlStatus, "control_status", partial(convert.control_bytes, name))
        self._neighbours = topics.add(NeighbourEstimates, "neighbours", convert.NeighboursWriter().filled)
        centre = sphere_stencil(f"{name} centre", 0, 0.15, (0.9, 0.2, 0.6, 1.0))
        self._marker = topics.add(MarkerArray, "/markers", centre.filled)
        self._drawn: set[int] = set()
        self._path = topics.add(Path, "path", qos=LATCHED) if agent.knows_path else None

    def publish_path(self, t_s: float) -> None:
        """Publish the path, if the agent knows it, with the stamp `t_s` (s)."""
        if self._path is None:
            return
        header = convert.header(t_s, convert.WORLD_FRAME)
        poses = []
        for place in self._path_points:
            pose = PoseStamped(header=header)
            pose.pose.position = convert.point(place)
            poses.append(pose)
        self._path.publish(Path(header=header, poses=poses))

    def publish(self, tick: int, t_s: float) -> None:
        """Publish the topics of a tick, with its stamp (s)."""
        agent = self._agent
        self._reference.publish(t_s, *agent.reference.velocity, 0.0, 0.0, 0.0)
        if agent.flocks:
            self._centre.publish(t_s, tick, *agent.centre, *agent.centre_rate)
        if agent.law_state or agent.holding:
            self._control.publish(t_s, tick, agent.holding, agent.law_state)
        neighbours = agent.neighbours
        self._neighbours.publish(t_s, tick, neighbours.addresses, neighbours.rows[:, :CENTRE])
        if tick % MARKER_TICKS == 0 and agent.flocks:
            self._marker.publish(t_s, *agent.centre)
        if tick % STANDING_MARKER_TICKS == 0 and self._standing_markers:
            for marker in self._standing_markers:
                marker.header.stamp = convert.stamp(t_s)
            self._marker.publisher.publish(MarkerArray(markers=self._standing_markers))
        if tick % MARKER_TICKS == 0:
            self._draw_sensed(t_s)

    def _draw_sensed(self, t_s: float) -> None:
        """Publish a ball for each sensed obstacle, and remove those that are forgotten."""
        sensed = {each.number: each for each in self._agent.sensed}
        name = f"{self._config.vehicle_id} sensed"
        gone = [removed(name, number, t_s) for number in sorted(self._drawn - set(sensed))]
        balls = [
            sphere(name, each.number, t_s, each.position, 2.0 * each.safety_distance_m, SENSED)
            for each in sensed.values()
        ]
        if gone or balls:
            self._marker.publisher.publish(MarkerArray(markers=[*gone, *balls]))
        self._drawn = set(sensed)

    @cached_property
    def _standing_markers(self) -> list[Any]:
        name = self._config.vehicle_id
        markers = []
        if self._agent.knows_path:
            markers.append(
                lines(f"{name} path", 0, 0.0, self._path_points, (0.3, 0.9, 0.3, 1.0), joined=True)
            )
        if self._config.address == 1:
            for number, (obstacle, safety_distance_m) in enumerate(self._config.obstacles):
                colour = (0.9, 0.3, 0.2, 0.25)
                markers.append(sphere("obstacles", number, 0.0, obstacle, 2.0 * safety_distance_m, colour))
        return markers

    @cached_property
    def _path_points(self) -> list[Vec3]:
        span_s = self._agent.path_period_s or _PATH_SPAN_S
        points = [self._agent.path_point(k * span_s / _PATH_POINTS) for k in range(_PATH_POINTS + 1)]
        return [point.position for point in points if point is not None]
