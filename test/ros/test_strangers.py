"""Nothing that a stranger on the graph does holds a run, ends it or gets into it."""

import os
import signal
import time

import pytest

pytest.importorskip("rclpy")

from ros_desk import desk, process
from std_msgs.msg import Int64

from auv_core.qos import EVERY_TICK, OWN_DEPTH, own_qos

pytestmark = pytest.mark.ros

MESSAGES = 6 * OWN_DEPTH
"""More than the 5000 that the middleware holds for a writer that keeps everything."""


def test_a_reader_that_stalls_holds_no_writer(tmp_path):
    with desk() as at:
        publisher = at.publisher(Int64, "said")
        heard = []
        at.node.create_subscription(Int64, "said", heard.append, EVERY_TICK, raw=True)
        with process("auv_bringup.topic", "hz", "/said") as echo:
            at.until(lambda: publisher.get_subscription_count() == 2, "both readers are found")
            os.kill(echo.pid, signal.SIGSTOP)
            longest_s = 0.0
            for number in range(MESSAGES):
                began_s = time.monotonic()
                publisher.publish(Int64(data=number))
                longest_s = max(longest_s, time.monotonic() - began_s)
                if number % 100 == 99:
                    at.until(lambda sent=number + 1: len(heard) == sent, "the own reader has everything")
    assert longest_s < 1.0


@pytest.mark.parametrize(("publishers", "numbers"), [("own", [7]), ("any", [6, 7])])
def test_who_is_heard_is_the_runs_own_or_anybody(publishers, numbers):
    with desk() as at:
        stranger, own = at.stranger(Int64, "said"), at.publisher(Int64, "said")
        heard, overheard = [], at.listen(Int64, "said")
        qos = own_qos(admits_strangers=publishers == "any")
        at.node.create_subscription(Int64, "said", heard.append, qos)
        at.until(lambda: stranger.get_subscription_count() == len(numbers), "discovery")
        at.until(lambda: own.get_subscription_count() == 2, "discovery")
        stranger.publish(Int64(data=6))
        at.until(lambda: len(overheard) == 1, "others hear the stranger")
        own.publish(Int64(data=7))
        at.until(lambda: len(overheard) == 2 and len(heard) == len(numbers), "everything is heard")
    assert sorted(message.data for message in heard) == numbers
