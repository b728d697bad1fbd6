"""Messages filled in as bytes are the messages that they claim to be."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.models import Handling, hovering

pytestmark = pytest.mark.ros

numbers = st.floats(allow_nan=False, allow_infinity=False)
vec3 = st.tuples(numbers, numbers, numbers)
vec6 = st.tuples(*[numbers] * 6)
times_s = st.floats(0.0, 1.9e9)


def states():
    from auv_core.messages import VehicleState

    quaternion = st.tuples(numbers, numbers, numbers, numbers)
    return st.builds(
        VehicleState, st.integers(0, 2**62), vec3, quaternion, vec6, st.booleans(), numbers, numbers
    )


def read(data, kind):
    from rclpy.serialization import deserialize_message

    return deserialize_message(data, kind)


def assert_stamped(header, t_s, frame_id):
    assert header.frame_id == frame_id
    assert header.stamp.sec + 1e-9 * header.stamp.nanosec == pytest.approx(t_s, abs=1e-6)


def test_a_state_survives_the_way_through_its_message():
    from auv_msgs.msg import VehicleState
    from auv_ros.wire import conversions as convert

    stencil = convert.state_stencil()

    @settings(deadline=None)
    @given(state=states(), t_s=times_s)
    def check(state, t_s):
        data = stencil.filled(t_s, *convert.state_numbers(state))
        message = read(data, VehicleState)
        assert_stamped(message.header, t_s, "map_ned")
        position, orientation = message.pose.position, message.pose.orientation
        assert message.tick == state.tick
        assert message.valid == state.is_valid
        assert (position.x, position.y, position.z) == state.position
        assert (orientation.w, orientation.x, orientation.y, orientation.z) == state.attitude
        assert (message.twist.linear.x, message.twist.angular.z) == (state.nu[0], state.nu[5])
        assert convert.state_from_bytes(data) == state

    check()


def test_odometry_has_the_estimate_with_its_covariance_in_the_axes_of_rep_103():
    from nav_msgs.msg import Odometry

    from auv_ros.wire import conversions as convert

    odometry = convert.odometry_stencil("auv_1/odom", "auv_1/base_link")

    @settings(deadline=None)
    @given(pose=st.tuples(*[numbers] * 7), variances=vec6, velocity=vec6, others=vec6, t_s=times_s)
    def check(pose, variances, velocity, others, t_s):
        message = read(odometry.filled(t_s, *pose, *variances, *velocity, *others), Odometry)
        assert_stamped(message.header, t_s, "auv_1/odom")
        assert message.child_frame_id == "auv_1/base_link"
        place, turned = message.pose.pose.position, message.pose.pose.orientation
        assert (place.x, place.y, place.z, turned.x, turned.y, turned.z, turned.w) == pose
        linear, angular = message.twist.twist.linear, message.twist.twist.angular
        assert (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z) == velocity
        assert np.array_equal(message.pose.covariance.reshape(6, 6), np.diag(variances))
        assert np.array_equal(message.twist.covariance.reshape(6, 6), np.diag(others))

    check()


def test_transforms_have_the_poses_of_all_frames():
    from tf2_msgs.msg import TFMessage

    from auv_ros.wire.transform_stencil import TransformStencil

    poses = st.tuples(*[numbers] * 7)

    @settings(deadline=None)
    @given(
        links=st.lists(
            st.tuples(st.text("abc/", max_size=9), st.text("abc/", max_size=9), poses), min_size=1
        ),
        t_s=times_s,
    )
    def check(links, t_s):
        stencil = TransformStencil([link[:2] for link in links])
        transforms = read(stencil.filled(t_s, [pose for _, _, pose in links]), TFMessage).transforms
        assert len(transforms) == len(links)
        for transform, (parent, child, pose) in zip(transforms, links, strict=True):
            assert_stamped(transform.header, t_s, parent)
            assert transform.child_frame_id == child
            place, turned = transform.transform.translation, transform.transform.rotation
            assert (place.x, place.y, place.z, turned.x, turned.y, turned.z, turned.w) == pose

    check()


@settings(deadline=None)
@given(attitude=st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1), position=vec3)
def test_a_pose_is_the_same_in_east_north_up(attitude, position):
    """The matrix of the pose, with the axes of both ends exchanged."""
    from scipy.spatial.transform import Rotation

    from auv_ros.wire import conversions as convert

    w, x, y, z = (number / math.hypot(*attitude) for number in attitude)
    east, north, up, *quaternion = convert.enu_pose(position, (w, x, y, z))
    assert (north, east, -up) == position
    ned_to_enu = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    flu_to_frd = np.diag([1.0, -1.0, -1.0])
    expected = ned_to_enu @ Rotation.from_quat([x, y, z, w]).as_matrix() @ flu_to_frd
    np.testing.assert_allclose(Rotation.from_quat(quaternion).as_matrix(), expected, atol=1e-12)


def test_commands_survive_the_way_through_their_messages():
    from auv_core.messages import FinCommand, ThrusterCommand, VelocityCommand, Wrench, command_numbers
    from auv_ros.wire.commands import command_bytes, command_from_bytes, command_topic
    from auv_ros.wire.stencil import header_stamp_s

    @settings(deadline=None)
    @given(tau=st.tuples(*[st.floats(-1e9, 1e9)] * 6), t_s=times_s, name=st.text("ab_1", max_size=9))
    def check(tau, t_s, name):
        for command, kind, frame in (
            (Wrench(tau), "wrench", f"{name}/base_link_frd"),
            (VelocityCommand(tau[:3], tau[5]), "velocity", "map_ned"),
            (FinCommand(*tau[:3]), "fins", f"{name}/base_link_frd"),
            (ThrusterCommand(tau[:1]), "thrusters", f"{name}/base_link_frd"),
            (ThrusterCommand(tau), "thrusters", f"{name}/base_link_frd"),
        ):
            data = command_bytes(name, kind, t_s, *command_numbers(command))
            assert_stamped(read(data, command_topic(kind)[0]).header, t_s, frame)
            assert header_stamp_s(data) == pytest.approx(t_s, abs=1e-6)
            assert command_from_bytes(data, kind, len(command_numbers(command))) == command

    check()


def test_outputs_of_actuators_have_their_names_and_units():
    from auv_core.models import Actuator
    from auv_msgs.msg import ActuatorStates
    from auv_ros.wire.commands import actuators_stencil

    data = actuators_stencil("a", [Actuator("rudder", "rad"), Actuator("propeller", "rpm")])
    message = read(data.filled(2.0, 0.1, 900.0), ActuatorStates)
    assert_stamped(message.header, 2.0, "a/base_link_frd")
    assert (message.names, message.units) == (["rudder", "propeller"], ["rad", "rpm"])
    assert list(message.outputs) == [0.1, 900.0]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300, -2e9])
def test_a_command_that_is_not_finite_is_refused(bad):
    from auv_ros.wire.commands import command_bytes, command_from_bytes

    for kind, size in (("wrench", 6), ("fins", 3), ("thrusters", 8)):
        data = command_bytes("a", kind, 1.0, bad, *[0.0] * (size - 1))
        with pytest.raises(ValueError, match="not finite"):
            command_from_bytes(data, kind, size)


def test_a_command_for_another_number_of_thrusters_is_refused():
    from auv_ros.wire.commands import command_bytes, command_from_bytes

    with pytest.raises(ValueError, match="6 forces; expected 8, one for each thruster"):
        command_from_bytes(command_bytes("a", "thrusters", 1.0, *[0.0] * 6), "thrusters", 8)


@given(data=st.binary(max_size=100))
def test_bytes_that_are_no_message_are_refused_and_nothing_else_happens(data):
    from auv_ros.wire import conversions as convert

    with pytest.raises(ValueError, match=r"\d bytes"):
        convert.state_from_bytes(data)


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_neighbour_estimates_hold_every_number(count):
    from auv_flocking.neighbours.estimates import AGE, COVARIANCE, PUBLISHED
    from auv_msgs.msg import NeighbourEstimates
    from auv_ros.wire import conversions as convert

    rows = np.arange(60.0 * count).reshape(count, 60)[:, 5 : 5 + PUBLISHED]
    stencil = convert.neighbours_stencil(range(1, count + 1))
    stencil.filled(1.0, 10, rows + 1.0)
    message = read(stencil.filled(2.5, 25, rows), NeighbourEstimates)
    assert_stamped(message.header, 2.5, "map_ned")
    assert (message.tick, len(message.neighbours)) == (25, count)
    for address, row, neighbour in zip(range(1, count + 1), rows, message.neighbours, strict=True):
        assert neighbour.address == address
        assert [neighbour.position.x, neighbour.velocity.z] == [row[0], row[5]]
        assert list(neighbour.covariance) == row[COVARIANCE:AGE].tolist()
        assert [neighbour.age_s, neighbour.sonar_age_s] == row[AGE:].tolist()


@pytest.mark.parametrize("name", ["auv_1.vehicle_node", ""])
def test_the_logger_of_a_line_is_read(name):
    from rcl_interfaces.msg import Log
    from rclpy.serialization import serialize_message

    from auv_ros.wire.log import logger_of

    line = Log(level=30, name=name, msg="a line", file="a.py", function="f", line=7)
    assert logger_of(bytes(serialize_message(line))) == name


def test_neighbours_come_and_go():
    from auv_msgs.msg import NeighbourEstimates
    from auv_ros.wire import conversions as convert

    writer = convert.NeighboursWriter()
    for addresses in ([], [2], [2, 4], [3, 4]):
        rows = np.arange(44.0 * len(addresses)).reshape(len(addresses), 44)
        message = read(writer.filled(2.5, 25, addresses, rows), NeighbourEstimates)
        assert [neighbour.address for neighbour in message.neighbours] == addresses
        assert [neighbour.position.x for neighbour in message.neighbours] == rows[:, 0].tolist()


def test_a_flocking_centre_holds_every_number():
    from auv_msgs.msg import FlockingCentre
    from auv_ros.wire import conversions as convert

    message = read(convert.centre_stencil().filled(2.5, 25, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0), FlockingCentre)
    position, velocity = message.position, message.velocity
    assert (message.tick, position.x, position.y, position.z) == (25, 1.0, 2.0, 3.0)
    assert (velocity.x, velocity.y, velocity.z) == (4.0, 5.0, 6.0)


def receptions():
    from auv_core.messages import Packet, Reception

    packet = st.builds(
        Packet, st.integers(0, 9), st.integers(1, 9), st.just(0), st.integers(1, 9), st.binary()
    )
    whole = st.integers(-(10**9), 10**15).map(lambda ns: ns * 1e-9)
    return st.builds(Reception, packet, whole, whole, numbers)


def stamp_ns(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def again(data, kind):
    """Return what ROS makes of a message that it has read."""
    from rclpy.serialization import serialize_message

    return serialize_message(read(data, kind))


def test_inbox_and_outbox_survive_the_way_through_their_messages():
    from auv_bag.definitions import load_message_type
    from auv_bag.padding import padding_zeroer
    from auv_core.messages import Inbox, SonarContact
    from auv_msgs.msg import AcousticInbox, AcousticOutbox
    from auv_ros.wire.acoustics import inbox_bytes, outbox_bytes, read_inbox, read_outbox

    contacts = st.builds(SonarContact, numbers, numbers, numbers)
    few = st.lists(receptions(), max_size=2).map(tuple)
    seen = st.lists(contacts, max_size=2).map(tuple)
    inboxes = st.builds(Inbox, st.integers(0, 2**40), st.booleans(), few, seen)
    clean_inbox = padding_zeroer(load_message_type("auv_msgs/msg/AcousticInbox"))
    clean_outbox = padding_zeroer(load_message_type("auv_msgs/msg/AcousticOutbox"))

    @settings(deadline=None)
    @given(
        inbox=inboxes,
        frame=st.sampled_from(["", "a/base", "auv_1/base_link_frd"]),
        t_s=times_s,
        epoch_ns=st.sampled_from([0, 10**9, 1_790_000_000_123_000_000 // 2]),
    )
    def check(inbox, frame, t_s, epoch_ns):
        data = inbox_bytes(frame, inbox, t_s, epoch_ns)
        assert read_inbox(data, epoch_ns) == inbox
        assert data == clean_inbox(again(data, AcousticInbox))
        message = read(data, AcousticInbox)
        assert_stamped(message.header, t_s, frame)
        assert (message.tick, message.transmit_ready) == (inbox.tick, inbox.transmit_ready)
        for ours, theirs in zip(inbox.receptions, message.receptions, strict=True):
            assert stamp_ns(theirs.sent) == epoch_ns + round(ours.sent_s * 1e9)
            assert stamp_ns(theirs.arrival) == epoch_ns + round(ours.arrival_s * 1e9)
            assert theirs.snr_db == ours.snr_db
            assert (ours.packet.source, ours.packet.payload) == (
                theirs.packet.source,
                bytes(theirs.packet.payload),
            )
        for ours, theirs in zip(inbox.contacts, message.contacts, strict=True):
            assert (ours.range_m, ours.elevation_rad) == (theirs.range_m, theirs.elevation_rad)
        packets = [reception.packet for reception in inbox.receptions]
        data = outbox_bytes(frame, inbox.tick, packets, t_s)
        assert read_outbox(data) == (inbox.tick, packets)
        assert data == clean_outbox(again(data, AcousticOutbox))
        message = read(data, AcousticOutbox)
        assert [packet.sequence for packet in message.packets] == [packet.sequence for packet in packets]

    check()


def test_the_acoustic_log_holds_every_number():
    from auv_bag.definitions import load_message_type
    from auv_bag.padding import padding_zeroer
    from auv_core.messages import AcousticEvent, Outcome
    from auv_msgs.msg import AcousticEvents
    from auv_ros.wire.acoustics import events_bytes

    events = [AcousticEvent(Outcome(k + 1), k, 9, 7 + k, 1.0 + k, 2.0 + k, 3.0 + k, 32) for k in range(3)]
    for count in range(4):
        data = events_bytes(25, events[:count], 2.5, 10**9)
        assert data == padding_zeroer(load_message_type("auv_msgs/msg/AcousticEvents"))(
            again(data, AcousticEvents)
        )
        message = read(data, AcousticEvents)
        assert_stamped(message.header, 2.5, "")
        assert message.tick == 25
        for ours, theirs in zip(events[:count], message.events, strict=True):
            assert stamp_ns(theirs.start) == 10**9 + round(ours.start_s * 1e9)
            assert stamp_ns(theirs.end) == 10**9 + round(ours.end_s * 1e9)
            fields = set(AcousticEvent._fields) - {"start_s", "end_s"}
            assert [getattr(ours, name) for name in fields] == [getattr(theirs, name) for name in fields]


@given(data=st.binary(max_size=60))
def test_bytes_that_are_no_inbox_or_outbox_are_refused(data):
    from auv_core.messages import Inbox, Packet, Reception
    from auv_ros.wire.acoustics import inbox_bytes, outbox_bytes, read_inbox, read_outbox

    reception = Reception(Packet(1, 2, 0, 3, b"payload"), 1.0, 2.0, 3.0)
    inbox = inbox_bytes("a", Inbox(1, True, (reception,), ()), 1.0, 0)
    outbox = outbox_bytes("a", 1, [reception.packet], 1.0)
    for read_it, whole in ((lambda each: read_inbox(each, 0), inbox), (read_outbox, outbox)):
        for broken in (data, whole[: len(data)], whole[:-1]):
            with pytest.raises(ValueError, match=r"\d bytes"):
                read_it(broken)


@pytest.mark.parametrize("holding", ["", "stale navigation: 0.8 s old"])
@pytest.mark.parametrize("size", [0, 1, 4])
def test_a_control_status_holds_what_the_law_remembers_and_why_it_holds(size, holding):
    from auv_msgs.msg import ControlStatus
    from auv_ros.wire import conversions as convert

    memory = tuple(1.5 * k for k in range(1, size + 1))
    data = convert.control_bytes("auv_1", 2.5, 25, holding, memory)
    message = read(data, ControlStatus)
    assert_stamped(message.header, 2.5, "auv_1/base_link_frd")
    assert (message.tick, message.holding, tuple(message.law_state)) == (25, holding, memory)


def test_a_sphere_filled_in_is_the_sphere_built():
    from rclpy.serialization import serialize_message
    from visualization_msgs.msg import MarkerArray

    from auv_ros.wire.markers import HULL, sphere, sphere_stencil

    stencil = sphere_stencil("auv_1", 3, 1.5, HULL)
    for centre in ((1.0, -2.0, 3.0), (0.0, 0.0, 0.0)):
        built = serialize_message(MarkerArray(markers=[sphere("auv_1", 3, 2.5, centre, 1.5, HULL)]))
        assert read(stencil.filled(2.5, *centre), MarkerArray) == read(built, MarkerArray)


@pytest.mark.parametrize("handling", [hovering(0.31), Handling(False, 0.8, 1.6, 0.19)])
def test_a_hull_filled_in_is_the_hull_built(handling):
    from rclpy.serialization import serialize_message
    from visualization_msgs.msg import MarkerArray

    from auv_ros.wire.markers import HULL, hull_marker, hull_stencil

    stencil, centre, (w, x, y, z) = (
        hull_stencil("auv_1", handling, HULL),
        (1.0, -2.0, 3.0),
        (0.5, 0.5, -0.5, 0.5),
    )
    built = MarkerArray(markers=[hull_marker("auv_1", 2.5, (centre, (w, x, y, z)), handling, HULL)])
    assert read(stencil.filled(2.5, *centre, x, y, z, w), MarkerArray) == read(
        serialize_message(built), MarkerArray
    )
    (marker,) = built.markers
    assert (marker.scale.x, marker.scale.y) == (handling.hull_length_m, handling.hull_diameter_m)
    assert (marker.pose.orientation.w, marker.pose.orientation.y) == (w, y)


def assert_serialises_to(data, message):
    """Compare bytes with the serialisation of ROS, except in the padding, which ROS does not set."""
    from rclpy.serialization import serialize_message

    from auv_bag.definitions import load_message_type
    from auv_bag.padding import padding_zeroer

    package, kind = type(message).__module__.split(".")[0], type(message).__name__
    zeroed = padding_zeroer(load_message_type(f"{package}/msg/{kind}"))
    assert zeroed(data) == zeroed(serialize_message(message))


@pytest.mark.parametrize("count", [0, 1, 4])
def test_counters_of_links_hold_every_number(count):
    from dataclasses import asdict

    from auv_msgs.msg import AcousticLinkStats, AcousticStats
    from auv_ros.wire import conversions as convert
    from auv_ros.wire.acoustics import stats_bytes
    from auv_sim.acoustics.links import DELAY_EDGES_S, LinkCounters

    links = [LinkCounters(*[*range(k, k + 8), [k + n for n in range(12)]]) for k in range(count)]
    rows = [((k + 1, k + 2, *link.numbers()), link.delay_counts) for k, link in enumerate(links)]
    messages = [
        AcousticLinkStats(source=k + 1, destination=k + 2, **asdict(link)) for k, link in enumerate(links)
    ]
    stats = AcousticStats(header=convert.header(2.5, ""), delay_edges_s=DELAY_EDGES_S, links=messages)
    assert_serialises_to(stats_bytes(DELAY_EDGES_S, rows, 2.5), stats)


@pytest.mark.parametrize("texts", [[], ["a"], ["ab", "", "abc", "Tiefe in \N{GREEK SMALL LETTER MU}m"]])
def test_diagnostics_hold_every_text(texts):
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

    from auv_ros.wire import conversions as convert
    from auv_ros.wire.diagnostics import Status, diagnostics_bytes

    warn = DiagnosticStatus.WARN
    ours = [Status(warn, text, "message", "id", [(each, text) for each in texts]) for text in texts]
    theirs = [
        DiagnosticStatus(
            level=warn,
            name=text,
            message="message",
            hardware_id="id",
            values=[KeyValue(key=each, value=text) for each in texts],
        )
        for text in texts
    ]
    message = DiagnosticArray(header=convert.header(2.5, ""), status=theirs)
    assert_serialises_to(diagnostics_bytes(ours, 2.5), message)


def test_lines_filled_in_are_the_lines_built():
    from visualization_msgs.msg import MarkerArray

    from auv_ros.wire.markers import LINK, LineList, lines

    line_list = LineList("links", 3, LINK)
    for points in ([], [(1.0, -2.0, 3.0), (0.0, 0.0, 0.0)], [(float(k), 0.5, -1.0) for k in range(6)]):
        built = MarkerArray(markers=[lines("links", 3, 2.5, points, LINK, joined=False)])
        assert_serialises_to(line_list.filled(2.5, points), built)
