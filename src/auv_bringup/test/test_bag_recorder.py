"""The recorder without ROS: which time each message gets."""

import pytest
import synthetic_bag as synthetic

from auv_bringup.bag import Bag
from auv_bringup.bag_recorder import BagRecorder
from auv_bringup.bag_writer import BagWriter, Qos
from auv_bringup.recorded_topics import CLOCK_TOPIC, topics_of_graph

SPECS = {spec.name: spec for spec in topics_of_graph(["auv_1"], kinematic=False)}


class Desk:
    """A recorder fed by hand."""

    def __init__(self, bag_dir, offered=()):
        self.bag_dir = bag_dir
        self.writer = BagWriter(bag_dir)
        self.recorder = BagRecorder(self.writer, lambda topic: tuple(offered), synthetic.message_type)
        self.sinks = {name: self.recorder.sink(spec) for name, spec in SPECS.items()}

    def take(self, topic, *messages):
        store = synthetic.typestore()
        self.sinks[topic]([bytes(store.serialize_cdr(each, each.__msgtype__)) for each in messages])

    def clock(self, *times_ns):
        stamps = map(synthetic.time, times_ns)
        self.take(CLOCK_TOPIC, *(synthetic.make("rosgraph_msgs/msg/Clock", clock=stamp) for stamp in stamps))

    def path(self, t_ns, topic="/auv_1/path"):
        header = synthetic.header(t_ns, "map_ned")
        self.take(topic, synthetic.make("nav_msgs/msg/Path", header=header, poses=[]))

    def centre(self, t_ns):
        zero = (0.0, 0.0, 0.0)
        self.take(
            "/auv_1/flocking_centre",
            synthetic.make(
                "auv_msgs/msg/FlockingCentre",
                header=synthetic.header(t_ns, "map_ned"),
                tick=0,
                position=synthetic.point(zero),
                velocity=synthetic.vector(zero),
            ),
        )

    def no_markers(self):
        self.take("/markers", synthetic.make("visualization_msgs/msg/MarkerArray", markers=[]))

    def log_line(self):
        self.take(
            "/rosout",
            synthetic.make(
                "rcl_interfaces/msg/Log",
                stamp=synthetic.time(1_700_000_000 * 10**9),
                level=20,
                name="n",
                msg="m",
                file="f",
                function="g",
                line=1,
            ),
        )

    def times(self):
        self.recorder.finish()
        return [(each.topic, each.time_ns) for each in Bag(self.bag_dir).messages()]


@pytest.fixture
def desk(tmp_path):
    return Desk(tmp_path / "bag")


def test_a_message_has_the_time_of_its_stamp(desk):
    desk.clock(100)
    desk.centre(300)
    desk.clock(200)
    desk.centre(250)
    expected = [
        ("/clock", 100),
        ("/clock", 200),
        ("/auv_1/flocking_centre", 250),
        ("/auv_1/flocking_centre", 300),
    ]
    assert desk.times() == expected
    assert desk.recorder.ticks == 2


def test_messages_that_come_together_have_their_own_times_and_nothing_enters_the_bag_without_one(desk):
    desk.clock(100, 200, 300)
    desk.take("/auv_1/flocking_centre")
    desk.no_markers()
    assert (desk.recorder.ticks, desk.recorder.now_ns) == (3, 300)
    assert desk.times() == [("/clock", 100), ("/clock", 200), ("/clock", 300), ("/markers", 300)]
    assert set(Bag(desk.bag_dir).topics) == {"/clock", "/markers"}


def test_a_message_without_a_stamp_has_the_time_of_the_newest_clock(desk):
    desk.clock(100)
    desk.centre(900)
    desk.no_markers()
    desk.log_line()
    assert desk.recorder.now_ns == 100
    assert desk.times()[1:3] == [("/markers", 100), ("/rosout", 100)]


def test_without_a_clock_the_newest_stamp_is_the_time(desk):
    desk.centre(500)
    desk.centre(400)
    desk.log_line()
    assert desk.times()[1:] == [("/auv_1/flocking_centre", 500), ("/rosout", 500)]


def test_what_has_no_time_before_the_first_stamp_gets_that_stamp(desk):
    desk.log_line()
    desk.path(0)
    desk.no_markers()
    desk.centre(700)
    desk.path(0)
    expected = ["/rosout", "/auv_1/path", "/markers", "/auv_1/flocking_centre", "/auv_1/path"]
    assert desk.times() == [(topic, 700) for topic in expected]


def test_what_stands_for_the_whole_run_has_the_time_of_its_begin_however_late_it_comes(desk):
    desk.clock(10, 20)
    desk.take("/auv_1/robot_description", synthetic.make("std_msgs/msg/String", data="<robot/>"))
    assert desk.times()[:2] == [(CLOCK_TOPIC, 10), ("/auv_1/robot_description", 10)]


def test_a_bag_without_any_stamp_keeps_its_messages(desk):
    desk.log_line()
    assert desk.times() == [("/rosout", 0)]


def test_a_topic_enters_the_bag_with_its_first_message_and_its_publishers_qos(tmp_path):
    offered = (Qos(history="unknown", durability="transient_local"), Qos(reliability="best_effort"))
    desk = Desk(tmp_path / "bag", offered)
    desk.path(5)
    desk.recorder.finish()
    topics = Bag(tmp_path / "bag").topics
    assert list(topics) == ["/auv_1/path"]
    profiles = topics["/auv_1/path"].offered_qos
    assert [each["reliability"] for each in profiles] == ["reliable", "best_effort"]
    assert profiles[0]["durability"] == "transient_local"


def test_a_publisher_that_has_gone_is_taken_for_a_usual_one(desk):
    desk.path(5)
    desk.centre(5)
    desk.recorder.finish()
    topics = Bag(desk.bag_dir).topics
    assert topics["/auv_1/path"].offered_qos[0]["durability"] == "transient_local"
    assert topics["/auv_1/flocking_centre"].offered_qos[0]["durability"] == "volatile"


def test_the_whole_graph_is_recorded_but_not_the_recorder():
    names = [spec.name for spec in topics_of_graph(["auv_1", "b"], kinematic=True)]
    assert len(names) == len(set(names)) == 9 + 2 * 13
    assert {"/auv_1/cmd_vel", "/b/cmd_vel", "/b/acoustic/rx", "/tf_static", "/clock"} <= set(names)
    assert "/auv_1/cmd_wrench" not in names
    assert "/recorder/status" not in names
