"""The frames of a run in its bag: one tree with known poses."""

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import RigidTransform, Rotation

from auv_bag.bag import Bag

pytestmark = [pytest.mark.ros, pytest.mark.xdist_group("frames")]

ROOT = Path(__file__).parents[2]
DRIFT = (
    "{kind: dead_reckoning, params: {fix: lbl, fix_period_s: 1.0, start_sd_m: 3.0, heading_bias_rad: 0.2}}"
)


@pytest.fixture(scope="module")
def messages(tmp_path_factory):
    """Return what a flight with a bad navigation recorded: decoded messages by topic and stamp (ns)."""
    out = tmp_path_factory.mktemp("frames")
    command = [sys.executable, "-m", "auv_bringup.tools.run", "flock_acoustic", "--mode", "lockstep"]
    command += ["--duration", "3", "--no-figures", "--layout", "single", "--out", str(out)]
    command += ["--set", f"environment.navigation={DRIFT}", "--set", "answer_timeout_s=30"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (folder,) = Path(out).iterdir()
    bag = Bag(folder)
    found: dict[str, Any] = {}
    for message in bag.messages(bag.topics.keys()):
        found.setdefault(message.topic, []).append(bag.decode(message))
    return found


def stamp_ns(header):
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def of_pose(position, turned):
    rotation = Rotation.from_quat([turned.x, turned.y, turned.z, turned.w])
    return RigidTransform.from_components([position.x, position.y, position.z], rotation)


def tree(messages, at_ns):
    """Return parent and transform by child, of one stamp and of all time."""
    links = [each for message in messages["/tf_static"] for each in message.transforms]
    links += [t for m in messages["/tf"] for t in m.transforms if stamp_ns(t.header) == at_ns]
    children = [link.child_frame_id for link in links]
    assert len(set(children)) == len(children), "a frame has two parents"
    return {
        link.child_frame_id: (
            link.header.frame_id,
            of_pose(link.transform.translation, link.transform.rotation),
        )
        for link in links
    }


def looked_up(links, target, source):
    """Return what brings coordinates of `source` into `target`."""

    def in_root(frame):
        found = RigidTransform.identity()
        while frame in links:
            frame, link = links[frame]
            found = link * found
        assert frame == "map"
        return found

    return in_root(target).inv() * in_root(source)


def assert_same(ours, theirs):
    np.testing.assert_allclose(ours.as_matrix(), theirs.as_matrix(), atol=1e-9)


def test_all_frames_are_one_tree_of_rep_105(messages):
    links = tree(messages, stamp_ns(messages["/auv_1/state"][-2].header))
    expected = {"map_ned": "map"}
    for name in ("auv_1", "auv_2", "auv_3", "auv_4"):
        expected[f"{name}/odom"] = expected[f"{name}/base_link_truth"] = "map"
        expected[f"{name}/base_link"] = f"{name}/odom"
        expected[f"{name}/base_link_frd"] = f"{name}/base_link"
    assert {child: parent for child, (parent, _) in links.items()} == expected


def test_a_known_pose_comes_out_in_every_frame(messages):
    for state, nav in zip(messages["/auv_2/state"], messages["/auv_2/nav"], strict=True):
        links = tree(messages, stamp_ns(state.header))
        believed, true = (of_pose(each.pose.position, each.pose.orientation) for each in (nav, state))
        assert_same(looked_up(links, "map_ned", "auv_2/base_link_frd"), believed)
        half_turn = RigidTransform.from_rotation(Rotation.from_rotvec([math.pi, 0.0, 0.0]))
        assert_same(looked_up(links, "map_ned", "auv_2/base_link_truth") * half_turn, true)
    assert np.linalg.norm(believed.translation - true.translation) > 0.01


def test_odometry_is_the_estimate_and_the_truth_has_a_topic_of_its_own(messages):
    at = {stamp_ns(each.header): each for each in messages["/auv_3/nav"]}
    true_at = {stamp_ns(each.header): each for each in messages["/auv_3/state"]}
    assert {stamp_ns(each.header) for each in messages["/auv_3/odom"]} == set(at)
    for topic, parent, child in (
        ("/auv_3/odom", "auv_3/odom", "auv_3/base_link"),
        ("/auv_3/ground_truth/odom", "map", "auv_3/base_link_truth"),
    ):
        for odometry in messages[topic]:
            assert (odometry.header.frame_id, odometry.child_frame_id) == (parent, child)
            links = tree(messages, stamp_ns(odometry.header))
            pose = of_pose(odometry.pose.pose.position, odometry.pose.pose.orientation)
            assert_same(looked_up(links, parent, child), pose)
    for odometry in messages["/auv_3/odom"]:
        nav = at[stamp_ns(odometry.header)]
        horizontal_m2, heading_rad2 = nav.position_sd_m**2, nav.heading_sd_rad**2
        diagonal = [horizontal_m2, horizontal_m2, 0.01**2, 0.0, 0.0, heading_rad2]
        np.testing.assert_allclose(odometry.pose.covariance.reshape(6, 6), np.diag(diagonal), atol=1e-15)
        assert odometry.twist.covariance[0] > 0.0
        assert odometry.twist.twist.linear.x == nav.twist.linear.x
        assert odometry.twist.twist.linear.y == -nav.twist.linear.y
    for odometry in messages["/auv_3/ground_truth/odom"]:
        true = true_at[stamp_ns(odometry.header)]
        assert odometry.pose.pose.position.z == -true.pose.position.z
        assert odometry.twist.twist.angular.z == -true.twist.angular.z
        assert not odometry.pose.covariance.any()


def test_rviz_has_a_model_of_every_vehicle(messages):
    config = yaml.safe_load((ROOT / "src/auv_bringup/config/shoal.rviz").read_text(encoding="utf-8"))
    displays = config["Visualization Manager"]["Displays"]
    models = [each for each in displays if each["Class"] == "rviz_default_plugins/RobotModel"]
    topics = {each["Description Topic"]["Value"] for each in models}
    assert topics == {topic for topic in messages if topic.endswith("/robot_description")}
    assert {each["Description Topic"]["Durability Policy"] for each in models} == {"Transient Local"}


def test_every_vehicle_describes_its_hull(messages):
    for name in ("auv_1", "auv_2", "auv_3", "auv_4"):
        (description,) = messages[f"/{name}/robot_description"]
        assert f'<link name="{name}/base_link">' in description.data
        assert 'sphere radius="0.31"' in description.data
