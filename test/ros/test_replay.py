"""The replay command as a process, heard by a real subscriber."""

import os
import signal
import time
from collections import defaultdict
from dataclasses import replace

import pytest

pytest.importorskip("rclpy")

import synthetic_bag as synthetic
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Path as PathMessage
from ros_desk import desk, finish, process
from rosgraph_msgs.msg import Clock

from auv_bag.writer import Topic
from auv_bringup.launching.domains import claim_domain
from auv_msgs.msg import VehicleState

pytestmark = pytest.mark.ros

REPLAY = "auv_bringup.tools.replay"
ENOUGH = ("--delay", 2.5)  # for discovery on a machine that is busy with other tests
N_TICKS = 30
KINDS = {"/clock": Clock, "/auv_1/state": VehicleState, "/auv_2/reference": TwistStamped}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A bag of 3 s, with a latched path at its beginning, and its messages by topic."""
    folder = tmp_path_factory.mktemp("recorded")
    recorder = synthetic.Recorder(folder / "bag", latched={"/auv_1/path"})
    header = synthetic.header(0, "map_ned")
    recorder.write("/auv_1/path", synthetic.make("nav_msgs/msg/Path", header=header, poses=[]), 0)
    synthetic.SyntheticRun(2, N_TICKS).write(recorder)
    recorder.writer.close()
    by_topic = defaultdict(list)
    for topic, _, _, data in recorder.log:
        by_topic[topic].append(data)
    return folder, by_topic


def listen(at):
    return {topic: at.listen(kind, topic, raw=True) for topic, kind in KINDS.items()}


def test_a_bag_is_published_as_it_was_recorded(recorded):
    folder, by_topic = recorded
    with desk() as at:
        heard = listen(at)
        paths = at.listen(PathMessage, "/auv_1/path", latched=True)
        began_s = time.monotonic()
        with process(REPLAY, folder, "--rate", 2, *ENOUGH) as replay:
            at.until(
                lambda: all(len(heard[topic]) == len(by_topic[topic]) for topic in heard), "all is heard"
            )
            assert time.monotonic() - began_s > 1.5
            status, out, errors = finish(replay, None)
    assert (status, errors) == (0, "")
    assert "messages of 19 topics replayed, 3.000 s of the bag" in out
    assert heard == {topic: by_topic[topic] for topic in heard}
    assert len(paths) == 1


def test_topics_start_and_clock_choose_what_is_published(recorded):
    folder, by_topic = recorded
    with desk() as at:
        heard = listen(at)
        paths = at.listen(PathMessage, "/auv_1/path", latched=True)
        wanted = ["--topics", "/auv_1/state", "/auv_1/path", "/clock"]
        with process(REPLAY, folder, "--start", 2, "--clock", 50, "--rate", 2, *ENOUGH, *wanted) as replay:
            status, out, errors = finish(replay, None)
        at.until(lambda: len(heard["/auv_1/state"]) == 11 and paths, "the end of the bag")
        at.until(lambda: len(heard["/clock"]) >= 20, "half a second of clock")
    assert (status, errors) == (0, "")
    assert "12 messages of 2 topics replayed, 1.000 s of the bag" in out
    assert heard["/auv_1/state"] == by_topic["/auv_1/state"][20:]
    assert heard["/auv_2/reference"] == []
    assert 20 <= len(heard["/clock"]) <= 30
    assert heard["/clock"][5] not in by_topic["/clock"]


def test_ctrl_c_ends_it_cleanly(recorded):
    folder, _ = recorded
    with desk() as at:
        heard = listen(at)
        with process(REPLAY, folder, "--rate", 0.01) as replay:
            at.until(lambda: heard["/clock"], "it has begun")
            status, _, errors = finish(replay, signal.SIGINT)
    assert status == 130
    assert errors == "error: interrupted\n"


def test_a_replay_that_waits_for_hours_can_be_ended_at_once(tmp_path):
    recorder = synthetic.Recorder(tmp_path / "bag")
    path = synthetic.make("nav_msgs/msg/Path", header=synthetic.header(0, "map_ned"), poses=[])
    for time_ns in (0, 50 * 10**9):  # 14 hours at this rate
        recorder.write("/auv_1/path", path, time_ns)
    recorder.writer.close()
    with desk() as at:
        heard = listen(at)
        with process(REPLAY, tmp_path, "--rate", 0.001, "--clock", 50, *ENOUGH) as replay:
            at.until(lambda: heard["/clock"], "it has begun")
            began_s = time.monotonic()
            status, _, errors = finish(replay, signal.SIGINT)
    assert (status, errors) == (130, "error: interrupted\n")
    assert time.monotonic() - began_s < 5.0


def test_an_unfinished_bag_is_replayed_as_far_as_it_goes(recorded, tmp_path):
    folder, _ = recorded
    content = (folder / "bag" / "bag_0.mcap").read_bytes()
    (tmp_path / "bag_0.mcap").write_bytes(content[: len(content) * 2 // 3])
    with desk(), process(REPLAY, tmp_path, "--rate", 50) as replay:
        status, out, errors = finish(replay, None)
    assert status == 0
    assert "replayed" in out
    assert errors.count("\n") == 1
    assert "killed before it finished; the file is repaired" in errors


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ["--topics", "/auv_1/state", "/nothing"],
            "the bag has no topic /nothing; it has: /acoustic/events",
        ),
        (["--start", "99"], "the bag is 3.000 s long"),
    ],
)
def test_what_cannot_be_replayed_is_one_error(recorded, options, said):
    folder, _ = recorded
    with process(REPLAY, folder, *options) as replay:
        status, _, errors = finish(replay, None)
    assert status == 2
    assert said in errors
    assert errors.count("\n") == 1


def test_a_replay_leaves_the_domain_of_a_run_to_it(recorded):
    folder, _ = recorded
    with claim_domain(os.environ) as claim, process(REPLAY, folder, "--rate", 100, "--delay", 0) as replay:
        status, _, errors = finish(replay, None)
    assert status == 0
    assert f"ROS domain {claim.domain_id} is in use by another run; this replay takes domain" in errors


def test_a_topic_whose_type_has_changed_is_left_out(tmp_path):
    recorder = synthetic.Recorder(tmp_path / "bag")
    synthetic.SyntheticRun(1, 3).write(recorder)
    other = replace(synthetic.message_type("auv_msgs/msg/VehicleState"), type_hash="RIHS01_" + "0" * 64)
    recorder.writer.write(recorder.writer.add_topic(Topic("/old/state", other)), b"\0\1\0\0", 0)
    recorder.writer.close()
    with process(REPLAY, tmp_path, "--delay", 0, "--rate", 10) as replay:
        status, out, errors = finish(replay, None)
    assert status == 0
    assert "messages of 10 topics replayed" in out
    why = "auv_msgs/msg/VehicleState is defined differently here than in the bag"
    assert errors.strip() == f"note: /old/state is left out: {why}"
