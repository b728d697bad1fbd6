"""What the recorder records: every topic of the graph, with its type and how it is published."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

CLOCK_TOPIC = "/clock"
STATUS_TOPIC = "/flock/status"
LOG_TOPIC = "/rosout"
"""Its writers are of the client library, which offers what strangers do."""


@dataclass(frozen=True)
class TopicSpec:
    """One topic of the graph.

    Attributes
    ----------
    name, type_name
        Full topic name and full type name.
    latched
        Published transient local: what was published before the recorder came is recorded too.
    stamped
        The stamp in its messages is the run's time; if not, it is the wall clock's.
    shared
        Several nodes publish it: the order of messages of one time means nothing.
    """

    name: str
    type_name: str
    latched: bool = False
    stamped: bool = True
    shared: bool = False


_VEHICLE_TOPICS = (
    TopicSpec("state", "auv_msgs/msg/VehicleState"),
    TopicSpec("nav", "auv_msgs/msg/VehicleState"),
    TopicSpec("odom", "nav_msgs/msg/Odometry"),
    TopicSpec("ground_truth/odom", "nav_msgs/msg/Odometry"),
    TopicSpec("robot_description", "std_msgs/msg/String", latched=True),
    TopicSpec("acoustic/tx", "auv_msgs/msg/AcousticOutbox"),
    TopicSpec("acoustic/rx", "auv_msgs/msg/AcousticInbox"),
    TopicSpec("reference", "geometry_msgs/msg/TwistStamped"),
    TopicSpec("flocking_centre", "auv_msgs/msg/FlockingCentre"),
    TopicSpec("control_status", "auv_msgs/msg/ControlStatus"),
    TopicSpec("neighbours", "auv_msgs/msg/NeighbourEstimates"),
    TopicSpec("path", "nav_msgs/msg/Path", latched=True),
)
_WRENCH_TOPIC = TopicSpec("cmd_wrench", "geometry_msgs/msg/WrenchStamped")
_VELOCITY_TOPIC = TopicSpec("cmd_vel", "geometry_msgs/msg/TwistStamped")
_GLOBAL_TOPICS = (
    TopicSpec("/acoustic/stats", "auv_msgs/msg/AcousticStats"),
    TopicSpec("/acoustic/events", "auv_msgs/msg/AcousticEvents"),
    TopicSpec("/tf", "tf2_msgs/msg/TFMessage", shared=True),
    TopicSpec("/tf_static", "tf2_msgs/msg/TFMessage", latched=True, shared=True),
    TopicSpec("/markers", "visualization_msgs/msg/MarkerArray", shared=True),
    TopicSpec("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", shared=True),
)
_CLOCK = TopicSpec(CLOCK_TOPIC, "rosgraph_msgs/msg/Clock")
_STATUS = TopicSpec(STATUS_TOPIC, "auv_msgs/msg/FlockStatus", latched=True)
_LOG = TopicSpec(LOG_TOPIC, "rcl_interfaces/msg/Log", latched=True, stamped=False)
SHARED_TOPICS = frozenset(spec.name for spec in _GLOBAL_TOPICS if spec.shared)


def topics_of_graph(vehicle_ids: Sequence[str], *, kinematic: bool, lockstep: bool) -> list[TopicSpec]:
    """Return the topics of a run that are recorded, what tells the time first.

    Not recorded are the recorder's own status and, in lock-step, log lines, whose stamps and order are the
    wall clock's.

    Parameters
    ----------
    vehicle_ids
        Names, and namespaces, of the vehicles.
    kinematic
        The vehicles take ``cmd_vel``, not ``cmd_wrench``.
    lockstep
        There is a ``/clock``.
    """
    per_vehicle = (*_VEHICLE_TOPICS, _VELOCITY_TOPIC if kinematic else _WRENCH_TOPIC)
    specs = [_CLOCK, _STATUS, *_GLOBAL_TOPICS] if lockstep else [_STATUS, *_GLOBAL_TOPICS, _LOG]
    for vehicle_id in vehicle_ids:
        specs += [replace(each, name=f"/{vehicle_id}/{each.name}") for each in per_vehicle]
    return specs
