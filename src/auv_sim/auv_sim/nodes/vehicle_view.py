"""A vehicle's topics for people and tools: odometry, ground truth, frames, hull."""

from __future__ import annotations

from nav_msgs.msg import Odometry
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from auv_core.geometry import Vec3
from auv_core.models import make_model
from auv_core.odom_frame import OdomFrame
from auv_msgs.msg import ActuatorStates
from auv_ros.qos import LATCHED
from auv_ros.robot_description import robot_description
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.commands import actuators_stencil
from auv_ros.wire.markers import HULL, MARKER_TICKS, hull_stencil
from auv_sim.vehicle import Vehicle, VehicleConfig

_EXACT = (0.0,) * 6


class VehicleView:
    """
    The topics of a vehicle node that no other node of the run reads.

    `odom` is the vehicle's own estimate in the frame `odom`, `ground_truth/odom` is the truth in `map`; both
    use the axes of REP-103. `/tf` has both, `robot_description` the hull, `actuators` the outputs
    of actuators that have a state.

    Parameters
    ----------
    topics : Topics
        Of the node of the vehicle; it gets these.
    config : VehicleConfig
        The vehicle; its frames begin with its name.
    velocity_sd_mps : Vec3
        Standard deviations of its estimated velocity (m/s; body).

    """

    def __init__(self, topics: Topics, config: VehicleConfig, velocity_sd_mps: Vec3) -> None:
        vehicle_id = config.vehicle_id
        base, truth = convert.base_frame(vehicle_id), convert.truth_frame(vehicle_id)
        model = make_model(config.model)
        description = robot_description(base, convert.body_frame(vehicle_id), model.handling)
        self._odom = topics.add(
            Odometry, "odom", convert.odometry_stencil(convert.odom_frame(vehicle_id), base).filled
        )
        self._truth = topics.add(
            Odometry, "ground_truth/odom", convert.odometry_stencil(convert.MAP_FRAME, truth).filled
        )
        self._tf = topics.add(TFMessage, "/tf", convert.motion_transforms(vehicle_id).filled)
        hull = hull_stencil(vehicle_id, model.handling, HULL)
        self._marker = topics.add(MarkerArray, "/markers", hull.filled)
        static = TFMessage(transforms=[convert.base_to_frd(vehicle_id)])
        topics.add(TFMessage, "/tf_static", qos=LATCHED).publish(static)
        topics.add(String, "robot_description", qos=LATCHED).publish(String(data=description))
        u, v, w = velocity_sd_mps
        self._velocity_variances = (u * u, v * v, w * w, 0.0, 0.0, 0.0)
        self._odom_frame = OdomFrame()
        actuators = model.actuators
        outputs = actuators_stencil(vehicle_id, actuators).filled
        self._outputs = topics.add(ActuatorStates, "actuators", outputs) if actuators else None
        self._odom_pose = convert.odom_in_map(self._odom_frame)

    def publish(self, t_s: float, vehicle: Vehicle) -> None:
        """
        Publish the topics at the time `t_s` (s).

        Without a valid navigation there is no `odom`, and on `/tf` the body stays at its last estimated
        pose. `ground_truth/odom` is published with the marker, not at every tick: that would take a tenth of
        a tick, and `/tf` has the same pose.
        """
        state, nav, navigation = vehicle.state, vehicle.nav, vehicle.navigation
        pose = true_pose = convert.enu_pose(state.position, state.attitude)
        if nav is not state:
            pose = convert.enu_pose(*navigation.odom_frame.pose(nav.position, nav.attitude))
            if navigation.odom_frame is not self._odom_frame:
                self._odom_frame = navigation.odom_frame
                self._odom_pose = convert.odom_in_map(self._odom_frame)
        if self._outputs is not None:
            self._outputs.publish(t_s, *vehicle.actuator_outputs)
        self._tf.publish(t_s, (self._odom_pose, pose, true_pose))
        if nav.is_valid:
            variances = convert.estimate_variances(nav, navigation.depth_sd_m)
            velocity = convert.flu_velocity(nav.nu)
            self._odom.publish(t_s, *pose, *variances, *velocity, *self._velocity_variances)
        if state.tick % MARKER_TICKS == 0:
            true_velocity = convert.flu_velocity(state.nu)
            self._truth.publish(t_s, *true_pose, *_EXACT, *true_velocity, *_EXACT)
            w, x, y, z = state.attitude
            self._marker.publish(t_s, *state.position, x, y, z, w)
