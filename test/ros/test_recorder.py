"""The recorder as a process, fed by a real graph."""

import os
import resource
import signal
from collections import defaultdict
from pathlib import Path

import pytest
import yaml

pytest.importorskip("rclpy")

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Path as PathMessage
from rclpy.duration import Duration
from rclpy.serialization import serialize_message
from rclpy.time import Time
from ros_desk import desk, finish, process
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from auv_bag.bag import Bag
from auv_bag.definitions import load_message_type
from auv_bag.padding import padding_zeroer
from auv_bag.topics import topics_of_graph
from auv_bringup.launching.node_start import CONTAINER_MODULE, Part, container_arguments
from auv_core.messages import COMMANDS
from auv_msgs.msg import FlockingCentre, RecorderStatus, VehicleState

pytestmark = pytest.mark.ros

RECORDER = "auv_bag.nodes.recorder_node"
TICK_NS = 100_000_000


def recorder_arguments(folder, vehicles=("auv_1", "auv_2"), *, alone=False):
    """Return the command line that the launcher would make; `alone`: that of the node by itself."""
    parameters = {"bag_dir": str(folder / "bag"), "topics_vehicles": list(vehicles)}
    parameters["commands"] = ["wrench" for _ in vehicles]
    parameters["mode"] = "lockstep"
    path = folder / "params.yaml"
    path.write_text(yaml.safe_dump({"/recorder_node": {"ros__parameters": parameters}}))
    if alone:
        return [RECORDER, "--ros-args", "--params-file", path]
    return [CONTAINER_MODULE, *container_arguments([Part(RECORDER, "/", str(path))])]


def writer_of(recorder):
    """Return the id of the process that writes a recorder's bag."""
    (pid,) = Path(f"/proc/{recorder.pid}/task/{recorder.pid}/children").read_text().split()
    return int(pid)


def canonical(message):
    """Return the bytes of a message without what the middleware leaves between the fields."""
    package, folder, _ = type(message).__module__.split(".")
    name = f"{package}/{folder}/{type(message).__name__}"
    return padding_zeroer(load_message_type(name))(serialize_message(message))


class Graph:
    """Publishes a few topics of a run, and remembers the bytes."""

    def __init__(self, at):
        self.desk = at
        self.clock = at.publisher(Clock, "/clock")
        self.states = [at.publisher(VehicleState, f"/auv_{i}/state") for i in (1, 2)]
        self.centre = at.publisher(FlockingCentre, "/auv_1/flocking_centre")
        self.tree = at.publisher(TFMessage, "/tf")
        self.path = at.publisher(PathMessage, "/auv_1/path", latched=True)
        self.published = defaultdict(list)
        self.send(self.path, PathMessage())

    @property
    def publishers(self):
        return [self.clock, *self.states, self.centre, self.tree, self.path]

    def send(self, publisher, message):
        self.published[publisher.topic_name].append(canonical(message))
        publisher.publish(message)

    def wait_for_recorder(self):
        everyone = [publisher.get_subscription_count for publisher in self.publishers]
        self.desk.until(lambda: all(count() >= 1 for count in everyone), "the recorder hears every topic")

    def run(self, ticks):
        for k in ticks:
            stamp = Time(nanoseconds=k * TICK_NS).to_msg()
            self.send(self.clock, Clock(clock=stamp))
            for publisher in self.states:
                state = VehicleState(tick=k)
                state.header.stamp = stamp
                state.pose.position.x = 0.1 * k
                self.send(publisher, state)
            centre = FlockingCentre(tick=k)
            centre.header.stamp = stamp
            self.send(self.centre, centre)
            transform = TransformStamped(child_frame_id="auv_1")
            transform.header.stamp = stamp
            self.send(self.tree, TFMessage(transforms=[transform]))

    def hand_over(self):
        for publisher in self.publishers:
            assert publisher.wait_for_all_acked(Duration(seconds=20))


def test_everything_published_is_in_the_bag(tmp_path):
    with desk() as at, process(*recorder_arguments(tmp_path)) as recorder:
        graph = Graph(at)
        statuses = at.listen(RecorderStatus, "/recorder/status", latched=True)
        graph.wait_for_recorder()
        hashes = {
            publisher.topic_name: at.node.get_publishers_info_by_topic(publisher.topic_name)[
                0
            ].topic_type_hash
            for publisher in graph.publishers
        }
        graph.run(range(300))
        at.until(lambda: statuses and statuses[-1].ticks >= 280, "the recorder says how far it is")
        graph.hand_over()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            os.kill(writer_of(recorder), number)  # as a desktop or a container that ends everything
        recorder.send_signal(signal.SIGINT)
        at.until(lambda: statuses[-1].closed, "the recorder says that the bag is closed")
        status, _, errors = finish(recorder, None)
    assert (status, errors) == (0, "")
    assert statuses[-1].ticks == 300
    assert statuses[-1].messages == sum(map(len, graph.published.values()))
    bag = Bag(tmp_path)
    assert bag.complete
    recorded = defaultdict(list)
    for message in bag.messages():
        recorded[message.topic].append(message.data)
    assert recorded == graph.published
    for topic, type_hash in hashes.items():
        assert bag.topics[topic].type_hash == str(type_hash)
    assert bag.topics["/auv_1/path"].offered_qos[0]["durability"] == "transient_local"
    assert bag.topics["/clock"].offered_qos[0]["deadline"] == {"sec": 9223372036, "nsec": 854775807}
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == statuses[-1].messages
        assert (reader.start_time, reader.end_time) == (0, 299 * TICK_NS + 1)


def record_1001_messages(at, folder):
    """Publish and wait until all of it is in the files of the bag."""
    graph = Graph(at)
    statuses = at.listen(RecorderStatus, "/recorder/status", latched=True)
    graph.wait_for_recorder()
    graph.run(range(200))
    at.until(lambda: statuses and statuses[-1].ticks == 200, "the recorder has all ticks")
    metadata = folder / "bag" / "metadata.yaml"
    at.until(lambda: "message_count: 1001" in metadata.read_text(), "metadata.yaml follows")
    return graph


def test_a_killed_recorder_leaves_a_closed_bag(tmp_path):
    with desk() as at, process(*recorder_arguments(tmp_path)) as recorder:
        graph = record_1001_messages(at, tmp_path)
        graph.run(range(200, 210))
        # Its output ends with the last process that has it: the one that writes the bag.
        assert finish(recorder, signal.SIGKILL)[0] == -signal.SIGKILL
    bag = Bag(tmp_path)
    assert bag.complete
    assert sum(1 for _ in bag.messages()) >= 1001


def test_a_killed_writer_ends_the_recorder_with_one_error_and_leaves_a_readable_bag(tmp_path):
    with desk() as at, process(*recorder_arguments(tmp_path)) as recorder:
        record_1001_messages(at, tmp_path)
        os.kill(writer_of(recorder), signal.SIGKILL)
        at.until(lambda: recorder.poll() is not None, "the recorder gives up")
        status, _, errors = finish(recorder, None)
    assert status == 1
    assert errors.count("\n") == 1
    assert f"cannot write the bag {tmp_path / 'bag'}: its process has ended (killed by SIGKILL)" in errors
    bag = Bag(tmp_path)
    assert not bag.complete
    assert sum(1 for _ in bag.messages()) >= 1001


@pytest.mark.parametrize("alone", [True, False])
def test_an_existing_bag_is_not_touched(tmp_path, alone):
    (tmp_path / "bag").mkdir()
    with process(*recorder_arguments(tmp_path, alone=alone)) as recorder:
        status, _, errors = finish(recorder, None)
    assert status == 2
    assert errors.count("\n") == 1
    assert "exists already" in errors
    assert list((tmp_path / "bag").iterdir()) == []


def test_a_full_disk_ends_the_recorder_with_one_error(tmp_path):
    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))

    with desk() as at, process(*recorder_arguments(tmp_path), limits=small_files) as recorder:
        graph = Graph(at)
        graph.wait_for_recorder()
        start = iter(range(0, 100_000, 20))

        def has_ended():
            graph.run(range(first := next(start), first + 20))
            return recorder.poll() is not None

        at.until(has_ended, "the recorder gives up")
        status, _, errors = finish(recorder, None)
    assert status == 1
    assert errors.count("cannot write the bag") == 1
    assert "Traceback" not in errors
    assert len(list(Bag(tmp_path).messages())) > 50


def test_the_types_of_the_graph_have_the_hashes_that_the_bag_states():
    import synthetic_bag as synthetic

    for command in COMMANDS:
        for spec in topics_of_graph(["a"], [command], lockstep=True):
            described = load_message_type(spec.type_name)
            assert described.type_hash == synthetic.message_type(spec.type_name).type_hash, spec
