"""The recorder without ROS: which time each message gets."""

from typing import Any

import numpy as np
import pytest
import synthetic_bag as synthetic

from auv_bag import recorder as bag_recorder
from auv_bag.bag import Bag
from auv_bag.recorder import FIRST_HELD_TICKS, LEAST_HELD_TICKS, BagRecorder
from auv_bag.topics import CLOCK_TOPIC, STATUS_TOPIC, topics_of_graph
from auv_bag.writer import BagWriter


def specs(*, lockstep):
    return topics_of_graph(["auv_1"], ["wrench"], lockstep=lockstep)


class Desk:
    """A recorder fed by hand."""

    def __init__(self, bag_dir, *, lockstep):
        self.bag_dir = bag_dir
        bag_dir.parent.mkdir(exist_ok=True)
        self.writer = BagWriter(bag_dir)
        self.recorder = BagRecorder(self.writer, lockstep=lockstep, describe=synthetic.message_type)
        self.sinks = {spec.name: self.recorder.sink(spec) for spec in specs(lockstep=lockstep)}

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

    def status(self, t_ns, state="running"):
        self.take(
            STATUS_TOPIC,
            synthetic.make(
                "auv_msgs/msg/FlockStatus",
                header=synthetic.header(t_ns, ""),
                state=state,
                tick=0,
                time_s=0.0,
                duration_s=1.0,
                waiting_for=[],
                lost_vehicles=[],
                detail="",
            ),
        )

    def transform(self, t_ns, child):
        zero = synthetic.vector((0.0, 0.0, 0.0))
        rotation = synthetic.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
        transform = synthetic.make(
            "geometry_msgs/msg/TransformStamped",
            header=synthetic.header(t_ns, "map"),
            child_frame_id=child,
            transform=synthetic.make("geometry_msgs/msg/Transform", translation=zero, rotation=rotation),
        )
        self.take("/tf", synthetic.make("tf2_msgs/msg/TFMessage", transforms=[transform]))

    def written(self):
        return [(each.topic, each.time_ns) for each in Bag(self.bag_dir).messages()]

    def times(self):
        self.recorder.finish()
        return self.written()


@pytest.fixture
def desk(tmp_path):
    return Desk(tmp_path / "bag", lockstep=True)


@pytest.fixture
def free(tmp_path):
    """The recorder of a run in real time."""
    return Desk(tmp_path / "bag", lockstep=False)


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


def test_a_message_without_a_stamp_has_the_time_of_the_newest_clock(desk):
    desk.clock(100)
    desk.centre(900)
    desk.no_markers()
    assert desk.recorder.now_ns == 100
    assert desk.times()[1:] == [("/markers", 100), ("/auv_1/flocking_centre", 900)]


def test_in_real_time_the_status_tells_the_time(free):
    free.status(0, "waiting")
    free.status(500)
    free.centre(700)
    free.log_line()
    free.status(900)
    assert free.recorder.now_ns == 900
    expected = [(STATUS_TOPIC, 500), ("/rosout", 500), ("/auv_1/flocking_centre", 700), (STATUS_TOPIC, 900)]
    assert free.times() == expected


def test_what_has_no_time_before_the_run_begins_gets_the_time_of_its_begin(free):
    free.log_line()
    free.path(0)
    free.no_markers()
    free.status(700)
    free.centre(700)
    free.path(700)
    expected = [STATUS_TOPIC, "/markers", "/rosout", "/auv_1/flocking_centre", "/auv_1/path", "/auv_1/path"]
    assert free.times() == [(topic, 700) for topic in expected]


def test_where_nobody_tells_the_time_the_first_stamp_is_the_begin(free):
    free.log_line()
    free.centre(500)
    assert free.times() == [("/rosout", 500), ("/auv_1/flocking_centre", 500)]


def test_what_stands_for_the_whole_run_has_the_time_of_its_begin_however_late_it_comes(desk):
    desk.clock(10, 20)
    desk.take("/auv_1/robot_description", synthetic.make("std_msgs/msg/String", data="<robot/>"))
    assert desk.times()[:2] == [(CLOCK_TOPIC, 10), ("/auv_1/robot_description", 10)]


def test_a_bag_without_any_stamp_keeps_its_messages(free):
    free.log_line()
    assert free.times() == [("/rosout", 0)]


@pytest.mark.parametrize("stamp_s", [0.0, 1.0, 1.79e9, 2.1e9])
@pytest.mark.parametrize("epoch_s", [1.0, 1.79e9 + 1.0])
def test_a_stamp_that_is_not_of_the_run_does_not_stretch_the_bag(tmp_path, stamp_s, epoch_s):
    for lockstep in (True, False):
        desk = Desk(tmp_path / f"bag_{lockstep}", lockstep=lockstep)
        for k in range(30):
            t_ns = round((epoch_s + 0.1 * k) * 1e9)
            desk.clock(t_ns) if lockstep else desk.status(t_ns)
            desk.centre(t_ns)
        desk.centre(round(stamp_s * 1e9))
        desk.recorder.finish()
        first_ns, last_ns = Bag(desk.bag_dir).span_ns()
        assert first_ns == round(epoch_s * 1e9)
        assert last_ns - first_ns <= 40e9


def test_bytes_that_are_no_message_do_not_enter_the_bag(desk):
    desk.clock(0)
    for topic in (CLOCK_TOPIC, "/auv_1/path"):
        desk.sinks[topic]([b"", bytes(30), b"\0\1\0\0" + b"\xff" * 40])
    desk.clock(100)
    assert desk.recorder.ticks == 2
    assert desk.recorder.left_out == {CLOCK_TOPIC: 3, "/auv_1/path": 3}


def test_the_order_of_arrival_leaves_no_trace_in_a_lockstep_bag(tmp_path, monkeypatch):
    first_held_ticks, held_ticks = 100, 20
    monkeypatch.setattr(bag_recorder, "FIRST_HELD_TICKS", first_held_ticks)
    monkeypatch.setattr(bag_recorder, "HELD_TICKS", held_ticks)

    def record(name, seed):
        desk, rng = Desk(tmp_path / name / "bag", lockstep=True), np.random.default_rng(seed)
        parts: list[list[Any]] = [[] for _ in range(4)]
        for k in range(2 * first_held_ticks + 10 * held_ticks):
            t_ns = (k + 10) * 10**8
            for part, call in zip(parts, (desk.clock, desk.centre, desk.path, desk.transform), strict=True):
                part.append((call, (t_ns, "a") if call == desk.transform else (t_ns,)))
            parts[3].insert(-1, (desk.transform, (t_ns, "b")))
        ahead = [0, 0, 0, 0]
        while any(parts):
            i = int(rng.integers(4))
            if parts[i] and ahead[i] <= min(ahead) + held_ticks:
                call, arguments = parts[i].pop(0)
                call(*arguments)
                ahead[i] += 2 if i < 3 else 1
            if rng.random() < 0.05:
                desk.recorder.flush()
            if rng.random() < 0.01:
                desk.writer.checkpoint(desk.recorder.held())
        desk.recorder.finish()
        return (desk.bag_dir / "bag_0.mcap").read_bytes()

    assert record("one", 1) == record("two", 2)


def test_a_first_message_that_is_sent_again_leaves_no_trace(tmp_path):
    def record(name, sent_at):
        desk = Desk(tmp_path / name / "bag", lockstep=True)
        for k in range(2 * FIRST_HELD_TICKS):
            desk.clock(100 + k)
            if k == sent_at:
                desk.path(100)
            desk.recorder.flush()
        desk.recorder.finish()
        return (desk.bag_dir / "bag_0.mcap").read_bytes()

    assert record("at once", 0) == record("again", FIRST_HELD_TICKS - 2)


def test_large_messages_are_not_held_back_for_long(desk, monkeypatch):
    monkeypatch.setattr(bag_recorder, "HELD_BYTES", 500)
    desk.clock(*range(100, 150))
    desk.recorder.flush()
    assert len(desk.recorder.held()) == LEAST_HELD_TICKS
    assert desk.times() == [(CLOCK_TOPIC, t_ns) for t_ns in range(100, 150)]


def test_what_is_held_back_is_in_the_file_after_a_pause(desk):
    desk.clock(*range(100, 400))
    desk.recorder.flush()
    for _ in range(2):
        desk.writer.checkpoint(desk.recorder.held())
    assert desk.written() == [(CLOCK_TOPIC, t_ns) for t_ns in range(100, 400)]
    desk.clock(400)
    assert desk.times() == [(CLOCK_TOPIC, t_ns) for t_ns in range(100, 401)]


def test_a_status_that_is_said_again_or_before_the_run_is_left_out(desk):
    desk.status(0, "waiting")
    desk.clock(100)
    for _ in range(3):
        desk.status(100)
    desk.status(200, "finished")
    assert [topic for topic, _ in desk.times()].count(STATUS_TOPIC) == 2


def test_every_topic_is_in_the_bag_with_what_a_replay_shall_offer(desk):
    desk.recorder.finish()
    topics = Bag(desk.bag_dir).topics
    assert set(topics) == {spec.name for spec in specs(lockstep=True)}
    for spec in specs(lockstep=True):
        (profile,) = topics[spec.name].offered_qos
        assert profile["durability"] == ("transient_local" if spec.latched else "volatile")
        assert (profile["reliability"], profile["liveliness"]) == ("reliable", "automatic")


def test_the_whole_graph_is_recorded_but_not_the_recorder():
    names = [spec.name for spec in topics_of_graph(["auv_1", "b"], ["velocity", "fins"], lockstep=True)]
    assert len(names) == len(set(names)) == 8 + 2 * 14
    assert {"/auv_1/cmd_vel", "/b/cmd_fins", "/b/acoustic/rx", "/tf_static", "/clock"} <= set(names)
    assert not {"/auv_1/cmd_wrench", "/recorder/status", "/rosout"} & set(names)
    in_real_time = {
        spec.name for spec in topics_of_graph(["auv_1", "b"], ["velocity", "fins"], lockstep=False)
    }
    assert in_real_time == set(names) - {"/clock"} | {"/rosout"}
