"""The recorded topics: every topic of the graph, with its type and how it is published."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from auv_bag.topic_spec import TopicSpec

CLOCK_TOPIC = "/clock"
STATUS_TOPIC = "/flock/status"
LOG_TOPIC = "/rosout"
"""Its writers belong to the client library, which offers the same QoS as foreign processes."""


_TOOLS = "tools"
_VEHICLE_TOPICS = (
    TopicSpec(
        "state",
        "auv_msgs/msg/VehicleState",
        publisher="vehicle_node",
        readers="acoustic_relay_node",
        every_ticks=1,
        fields="The truth. `tick`, `pose` and `twist`; the deviations are 0.",
        silence="Lock-step waits. In real time the relay puts no packet of this vehicle on the air after "
        "`state_max_age_s`. After `answer_timeout_s` the vehicle is lost.",
    ),
    TopicSpec(
        "nav",
        "auv_msgs/msg/VehicleState",
        publisher="vehicle_node, or a navigation",
        readers="agent_node",
        every_ticks=1,
        fields="The estimate that the vehicle uses. `tick` gives its age, `valid` whether there is one; "
        "`position_sd_m`, `heading_sd_rad` and `bounded` go into reports and filters.",
        silence="Lock-step waits. In real time the agent gives the safe command and sends nothing after "
        "`agent.inputs.nav_max_age_s`.",
    ),
    TopicSpec(
        "odom",
        "nav_msgs/msg/Odometry",
        publisher="vehicle_node",
        readers=_TOOLS,
        every_ticks=1,
        fields="`pose` in `auv_i/odom` and `twist` in `auv_i/base_link`, each with its covariance.",
        silence="The navigation has no valid solution.",
    ),
    TopicSpec(
        "ground_truth/odom",
        "nav_msgs/msg/Odometry",
        publisher="vehicle_node",
        readers=_TOOLS,
        every_ticks=5,
        fields="The truth: `pose` in `map`, `twist` in `auv_i/base_link_truth`; the covariances are 0.",
        silence="The vehicle node has ended.",
    ),
    TopicSpec(
        "actuators",
        "auv_msgs/msg/ActuatorStates",
        publisher="vehicle_node",
        readers=_TOOLS,
        comes="every tick, from vehicles whose actuators have a state",
        fields="`names`, `units` and `outputs` of the actuators: what acts, after the delay of each.",
        silence="The vehicle's actuators obey at once, or the vehicle node has ended.",
    ),
    TopicSpec(
        "robot_description",
        "std_msgs/msg/String",
        latched=True,
        publisher="vehicle_node",
        readers=_TOOLS,
        comes="once, at the start",
        fields="`data`: the hull as URDF.",
        silence="The vehicle node has not started.",
    ),
    TopicSpec(
        "acoustic/tx",
        "auv_msgs/msg/AcousticOutbox",
        publisher="agent_node",
        readers="acoustic_relay_node, or a modem driver",
        every_ticks=1,
        comes="even without a packet",
        fields="`packets`: packets of the agent for its modem in this tick; `payload` is transmitted.",
        silence="Lock-step waits. After `answer_timeout_s` the vehicle is lost.",
    ),
    TopicSpec(
        "acoustic/rx",
        "auv_msgs/msg/AcousticInbox",
        publisher="acoustic_relay_node, or a modem driver",
        readers="agent_node",
        every_ticks=1,
        comes="even without content",
        fields="`receptions`; `transmit_ready`: the modem asks for data; `contacts` of the sonar.",
        silence="Lock-step waits. In real time the agent of a fleet gives the safe command after "
        "`agent.inputs.inbox_max_age_s`.",
    ),
    TopicSpec(
        "reference",
        "geometry_msgs/msg/TwistStamped",
        publisher="agent_node",
        readers=_TOOLS,
        every_ticks=1,
        fields="`twist.linear`: the velocity that the flocking law asks for (m/s, map_ned).",
        silence="The agent has ended.",
    ),
    TopicSpec(
        "flocking_centre",
        "auv_msgs/msg/FlockingCentre",
        publisher="agent_node",
        readers=_TOOLS,
        every_ticks=1,
        comes="of a flock",
        fields="The agent's own estimate of the centre: `position`, `velocity`.",
        silence="The vehicles follow a path or a region and do not flock.",
    ),
    TopicSpec(
        "control_status",
        "auv_msgs/msg/ControlStatus",
        publisher="agent_node",
        readers=_TOOLS,
        comes="every tick for a law with a state; for others, in ticks with the safe command",
        fields="`holding`: why the agent gives the safe command, empty while the law acts; `law_state`.",
        silence="The law acts and has no state.",
    ),
    TopicSpec(
        "neighbours",
        "auv_msgs/msg/NeighbourEstimates",
        publisher="agent_node",
        readers=_TOOLS,
        every_ticks=1,
        fields="`neighbours`: for each its `position`, `velocity`, `covariance`, `age_s` and `sonar_age_s`.",
        silence="The agent has ended. An empty list means that it has no neighbour estimate.",
    ),
    TopicSpec(
        "path",
        "nav_msgs/msg/Path",
        latched=True,
        publisher="agent_node",
        readers=_TOOLS,
        comes="once, from vehicles that know the path",
        fields="`poses`: points of the path (m, map_ned).",
        silence="The vehicle follows others.",
    ),
)
_RESTS = "Lock-step waits. In real time the actuators rest after `command_max_age_s`."


def _command_topic(name: str, type_name: str, comes: str, fields: str) -> TopicSpec:
    """Return the topic of a kind of command."""
    return TopicSpec(
        name,
        type_name,
        publisher="agent_node",
        readers="vehicle_node",
        every_ticks=1,
        comes=comes,
        fields=f"{fields}; the stamp gives the tick.",
        silence=_RESTS,
    )


_COMMAND_TOPICS = {
    "wrench": _command_topic(
        "cmd_wrench",
        "geometry_msgs/msg/WrenchStamped",
        "from vehicles with a mass",
        "`wrench.force` (N) and `wrench.torque` (N m), body FRD",
    ),
    "velocity": _command_topic(
        "cmd_vel",
        "geometry_msgs/msg/TwistStamped",
        "from kinematic vehicles",
        "`twist.linear` (m/s, map_ned) and `twist.angular.z` (rad/s)",
    ),
    "fins": _command_topic(
        "cmd_fins",
        "auv_msgs/msg/FinCommand",
        "from torpedoes",
        "`rudder_rad`, `stern_plane_rad`, `propeller_rpm`",
    ),
    "thrusters": _command_topic(
        "cmd_thrusters",
        "auv_msgs/msg/ThrusterCommand",
        "from vehicles with thrusters",
        "`forces_n`: the force of each thruster (N)",
    ),
}
_GLOBAL_TOPICS = (
    TopicSpec(
        "/acoustic/stats",
        "auv_msgs/msg/AcousticStats",
        publisher="acoustic_relay_node",
        readers=_TOOLS,
        every_ticks=10,
        comes="and at the end",
        fields="`links`: counters of each directed link since the start, by cause of loss; `delay_counts`.",
        silence="The run waits, or the relay has ended.",
    ),
    TopicSpec(
        "/acoustic/events",
        "auv_msgs/msg/AcousticEvents",
        publisher="acoustic_relay_node",
        readers=_TOOLS,
        comes="in ticks with new events",
        fields="`events`: `outcome`, `source`, `destination`, `sequence`, `start`, `end`.",
        silence="No modem has transmitted.",
    ),
    TopicSpec(
        "/tf",
        "tf2_msgs/msg/TFMessage",
        shared=True,
        publisher="vehicle_node",
        readers=_TOOLS,
        comes="every tick, from each vehicle",
        fields="`map -> auv_i/odom -> auv_i/base_link`, and the truth `map -> auv_i/base_link_truth`.",
        silence="The vehicle node has ended. Without a valid navigation the estimate does not move.",
    ),
    TopicSpec(
        "/tf_static",
        "tf2_msgs/msg/TFMessage",
        latched=True,
        shared=True,
        publisher="clock_node, vehicle_node",
        readers=_TOOLS,
        comes="once, from each publisher",
        fields="`map -> map_ned`, `auv_i/base_link -> auv_i/base_link_frd`.",
        silence="The node has not started.",
    ),
    TopicSpec(
        "/markers",
        "visualization_msgs/msg/MarkerArray",
        shared=True,
        publisher="acoustic_relay_node, vehicle_node, agent_node",
        readers=_TOOLS,
        comes="every 5 ticks; path and obstacles every 50",
        fields="Hulls, recent links, flocking centres, path, obstacles.",
        silence="The nodes have ended.",
    ),
    TopicSpec(
        "/diagnostics",
        "diagnostic_msgs/msg/DiagnosticArray",
        shared=True,
        publisher="acoustic_relay_node, vehicle_node, agent_node",
        readers=_TOOLS,
        comes="every 10 ticks of relay and agents, every 20 of vehicles, and at each change",
        fields="`status[].level` and `message`: inputs, neighbours, control law, commands, links; "
        "in real time also other programs that publish on topics of the run.",
        silence="The nodes have ended.",
    ),
)
_CLOCK = TopicSpec(
    CLOCK_TOPIC,
    "rosgraph_msgs/msg/Clock",
    publisher="clock_node",
    readers="recorder_node, tools with use_sim_time",
    every_ticks=1,
    comes="in lock-step",
    fields="`clock`: epoch + scenario time of the tick that begins.",
    silence="In lock-step the run waits; `/flock/status` names the node. Real time has no such topic.",
)
_STATUS = TopicSpec(
    STATUS_TOPIC,
    "auv_msgs/msg/FlockStatus",
    latched=True,
    publisher="clock_node",
    readers="every node, launcher",
    comes="every 20 ticks and at each change; in real time every 0.2 s",
    fields="`state`, `tick`, `time_s`, `waiting_for`, `lost_vehicles`, `detail`.",
    silence="The process of relay and clock has ended, and with it the run.",
)
_LOG = TopicSpec(
    LOG_TOPIC,
    "rcl_interfaces/msg/Log",
    latched=True,
    stamped=False,
    publisher="every node",
    readers=_TOOLS,
    comes="with each log line",
    fields="`level`, `name`, `msg`. Recorded in real time only.",
    silence="There are no log lines.",
)
RECORDER_TOPIC = TopicSpec(
    "/recorder/status",
    "auv_msgs/msg/RecorderStatus",
    latched=True,
    publisher="recorder_node",
    readers="clock_node",
    comes="about every 20 ticks and every second; not recorded",
    fields="`ticks` written, `bytes` of the bag, `closed`.",
    silence="There is no recorder. If a recorder is silent for `answer_timeout_s`, the run ends.",
)
SHARED_TOPICS = frozenset(spec.name for spec in _GLOBAL_TOPICS if spec.shared)
VEHICLE_TOPICS = (*_VEHICLE_TOPICS, *_COMMAND_TOPICS.values())
COMMON_TOPICS = (_CLOCK, _STATUS, *_GLOBAL_TOPICS, _LOG, RECORDER_TOPIC)


def topics_of_graph(
    vehicle_ids: Sequence[str], commands: Sequence[str], *, lockstep: bool
) -> list[TopicSpec]:
    """Return the recorded topics of a run; those with the run's time come first.

    The recorder's own status is not recorded, and in lock-step log lines are not, since their stamps and
    order depend on the wall clock.

    Parameters
    ----------
    vehicle_ids
        Names, and namespaces, of the vehicles.
    commands
        The kind of command that each vehicle takes.
    lockstep
        Whether there is a ``/clock``.
    """
    specs = [_CLOCK, _STATUS, *_GLOBAL_TOPICS] if lockstep else [_STATUS, *_GLOBAL_TOPICS, _LOG]
    for vehicle_id, command in zip(vehicle_ids, commands, strict=True):
        own = (*_VEHICLE_TOPICS, _COMMAND_TOPICS[command])
        specs += [replace(each, name=f"/{vehicle_id}/{each.name}") for each in own]
    return specs
