"""A written bag, as the rosbags library, the mcap library and rosbag2's conventions see it."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress

import pytest
import synthetic_bag as synthetic
import yaml
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Chunk, ChunkIndex
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability

from auv_bag.writer import BagError, BagWriter, Qos, Topic


@pytest.fixture
def run_bag(tmp_path):
    recorder = synthetic.Recorder(tmp_path / "bag")
    synthetic.SyntheticRun(2, 40).write(recorder, extras=True)
    recorder.writer.close()
    return tmp_path / "bag", recorder.log


def test_rosbags_reads_every_message_type_hash_and_time(run_bag):
    bag_dir, log = run_bag
    store = synthetic.typestore()
    with AnyReader([bag_dir]) as reader:
        connections = {each.topic: each for each in reader.connections}
        assert {name: each.msgtype for name, each in connections.items()} == {
            topic: name for topic, name, _, _ in log
        }
        for topic, connection in connections.items():
            assert connection.msgcount == sum(topic == each[0] for each in log)
            assert connection.digest == store.hash_rihs01(connection.msgtype)
            assert reader.typestore.hash_rihs01(connection.msgtype) == connection.digest
            (qos,) = connection.ext.offered_qos_profiles
            assert (qos.history, qos.reliability) == (QosHistory.KEEP_ALL, QosReliability.RELIABLE)
            assert qos.durability == QosDurability.VOLATILE
            assert (qos.deadline.sec, qos.deadline.nsec) == (9223372036, 854775807)
        read = [(c.topic, c.msgtype, t_ns, bytes(data)) for c, t_ns, data in reader.messages()]
        assert sorted(read) == sorted(log)
        topic, name, _, data = next(each for each in log if each[0] == "/auv_2/state")
        assert reader.deserialize(data, name).tick == store.deserialize_cdr(data, name).tick
        assert (reader.start_time, reader.end_time) == (0, 4_000_000_001)


def test_the_mcap_file_follows_rosbag2(run_bag):
    bag_dir, log = run_bag
    with (bag_dir / "bag_0.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        for channel in summary.channels.values():
            assert channel.message_encoding == "cdr"
            assert channel.metadata.keys() == {"offered_qos_profiles", "topic_type_hash"}
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
            assert yaml.safe_load(channel.metadata["offered_qos_profiles"])[0]["reliability"] == "reliable"
        assert summary.statistics.message_count == len(log)
        at_start, at_end = reader.iter_metadata()
        assert at_start.name == at_end.name == "rosbag2"
        at_end = yaml.safe_load(at_end.metadata["serialized_metadata"])
    outside = yaml.safe_load((bag_dir / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert at_end == outside
    assert yaml.safe_load(at_start.metadata["serialized_metadata"])["message_count"] == 0


def unfinished_chunks(file):
    with suppress(EndOfFile):
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Chunk):
                yield record


def test_chunks_are_small_compressed_and_reach_the_file_when_full(tmp_path):
    recorder = synthetic.Recorder(tmp_path / "bag")
    synthetic.SyntheticRun(2, 120).write(recorder)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as file:
        chunks = list(unfinished_chunks(file))
    recorder.writer.close()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as file:
        index: list[ChunkIndex] = make_reader(file).get_summary().chunk_indexes
    assert len(chunks) == len(index) - 1 > 3
    assert all(each.compression == "zstd" and each.uncompressed_size < 80_000 for each in index)


METADATA = """\
rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  duration:
    nanoseconds: 300000000
  starting_time:
    nanoseconds_since_epoch: 100000000
  message_count: 2
  topics_with_message_count:
    - topic_metadata:
        name: /path
        type: nav_msgs/msg/Path
        serialization_format: cdr
        offered_qos_profiles:
          - history: unknown
            depth: 0
            reliability: reliable
            durability: transient_local
            deadline:
              sec: 9223372036
              nsec: 854775807
            lifespan:
              sec: 9223372036
              nsec: 854775807
            liveliness: automatic
            liveliness_lease_duration:
              sec: 9223372036
              nsec: 854775807
            avoid_ros_namespace_conventions: false
        type_description_hash: RIHS01_1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b
      message_count: 2
  compression_format: ""
  compression_mode: ""
  relative_file_paths:
    - run_0.mcap
  files:
    - path: run_0.mcap
      starting_time:
        nanoseconds_since_epoch: 100000000
      duration:
        nanoseconds: 300000000
      message_count: 2
  custom_data: ~
  ros_distro: jazzy
"""


def test_metadata_reads_as_jazzy_writes_it(tmp_path):
    writer = BagWriter(tmp_path / "run")
    qos = Qos(history="unknown", durability="transient_local")
    channel = writer.add_topic(Topic("/path", synthetic.message_type("nav_msgs/msg/Path"), (qos,)))
    writer.write(channel, b"\0\1\0\0", 400_000_000)
    writer.write(channel, b"\0\1\0\0", 100_000_000)
    writer.close()
    assert (tmp_path / "run" / "metadata.yaml").read_text() == METADATA


def test_metadata_is_there_from_the_start_and_follows_at_checkpoints(tmp_path):
    def count():
        text = (tmp_path / "bag" / "metadata.yaml").read_text()
        return yaml.safe_load(text)["rosbag2_bagfile_information"]["message_count"]

    writer = BagWriter(tmp_path / "bag")
    assert count() == 0
    channel = writer.add_topic(Topic("/path", synthetic.message_type("nav_msgs/msg/Path")))
    writer.write(channel, b"\0\1\0\0", 1)
    assert count() == 0
    writer.checkpoint()
    pause, deadline_s = threading.Event(), time.monotonic() + 20.0
    while count() != 1:  # the disk takes its time, and a flight does not wait for it
        assert time.monotonic() < deadline_s
        pause.wait(0.005)
    writer.write(channel, b"\0\1\0\0", 2)
    writer.close()
    assert count() == 2
    assert sorted(path.name for path in (tmp_path / "bag").iterdir()) == ["bag_0.mcap", "metadata.yaml"]


def test_a_bag_is_never_overwritten(tmp_path):
    BagWriter(tmp_path / "bag").close()
    before = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    with pytest.raises(BagError, match="exists already"):
        BagWriter(tmp_path / "bag")
    assert (tmp_path / "bag" / "bag_0.mcap").read_bytes() == before
    (tmp_path / "file").write_text("")
    with pytest.raises(BagError, match="cannot create the bag"):
        BagWriter(tmp_path / "file" / "bag")


def test_a_folder_that_was_moved_away_is_not_made_again(tmp_path):
    with pytest.raises(BagError, match=r"cannot create the bag .*: its folder is gone: it was moved"):
        BagWriter(tmp_path / "moved" / "bag")
    assert list(tmp_path.iterdir()) == []


KILLED_WRITER = """
import os, signal, sys
sys.path[:0] = {paths!r}
import synthetic_bag as synthetic
from pathlib import Path
recorder = synthetic.Recorder(Path({bag!r}))
synthetic.SyntheticRun(2, 100).write(recorder)
print(len(recorder.log), flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_writer_leaves_all_but_the_last_chunk(tmp_path):
    from auv_bag.bag import Bag

    bag_dir = tmp_path / "bag"
    script = KILLED_WRITER.format(paths=[p for p in sys.path if p], bag=str(bag_dir))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, env=os.environ
    )
    assert done.returncode == -signal.SIGKILL, done.stderr
    written = int(done.stdout)
    bag = Bag(bag_dir)
    read = list(bag.messages())
    assert not bag.complete
    assert written - 64 * 1024 // 100 < len(read) <= written
    assert {topic.type_name for topic in bag.topics.values()} >= {"auv_msgs/msg/VehicleState"}
