"""Claims about the frame `odom`: corrections of an estimate move it, and not the pose in it."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from auv_core.geometry import heading_from_quaternion, quaternion_from_heading, quaternion_product
from auv_core.odom_frame import OdomFrame

metres = st.floats(-100.0, 100.0)
pairs = st.tuples(metres, metres)
angles = st.floats(-3.0, 3.0)


def test_without_corrections_it_is_the_world():
    pose = (1.0, 2.0, 3.0), quaternion_from_heading(0.4)
    assert OdomFrame().pose(*pose) == pose


@given(
    frame=st.builds(OdomFrame, metres, metres, angles), at=pairs, moved=pairs, turned=angles, heading=angles
)
def test_a_correction_leaves_the_pose_in_it_alone(frame, at, moved, turned, heading):
    attitude = quaternion_from_heading(heading)
    before = frame.pose((*at, 5.0), attitude)
    corrected = quaternion_product(quaternion_from_heading(turned), attitude)
    after = frame.corrected(at, moved, turned).pose((at[0] + moved[0], at[1] + moved[1], 5.0), corrected)
    np.testing.assert_allclose(after[0], before[0], atol=1e-9)
    np.testing.assert_allclose(after[1], before[1], atol=1e-12)


def test_a_turned_frame_turns_what_is_seen_from_it():
    position, attitude = OdomFrame(10.0, 20.0, math.pi / 2).pose(
        (10.0, 23.0, 5.0), quaternion_from_heading(1.0)
    )
    np.testing.assert_allclose(position, (3.0, 0.0, 5.0), atol=1e-12)
    assert math.isclose(heading_from_quaternion(attitude), 1.0 - math.pi / 2)
