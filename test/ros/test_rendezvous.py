"""Nodes find each other before a run begins, and nobody who cannot be matched keeps them from it."""

import time

import pytest

pytestmark = pytest.mark.ros

LIMIT_S = 20.0


@pytest.fixture
def ros():
    """Return a function that makes nodes and one that spins them until a condition holds."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    executor, nodes = SingleThreadedExecutor(context=context), []

    def node(name):
        made = rclpy.create_node(name, context=context)
        nodes.append(made)
        executor.add_node(made)
        return made

    def spin_until(condition):
        deadline = time.monotonic() + LIMIT_S
        while not condition() and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
        return condition()

    yield node, spin_until
    for made in nodes:
        made.destroy_node()
    rclpy.shutdown(context=context)


def test_a_reader_that_asks_for_more_than_is_offered_keeps_nobody_waiting(ros):
    from std_msgs.msg import Int64

    from auv_core.node_main import EVERY_TICK, LATCHED, Audience, Rendezvous

    node, spin_until = ros
    talker, listener, stranger = node("talker"), node("listener"), node("stranger")
    publisher = talker.create_publisher(Int64, "said", EVERY_TICK)
    stranger.create_subscription(Int64, "said", lambda _: None, LATCHED)
    ready = []
    meeting = Rendezvous(talker, [Audience(publisher, frozenset({"/listener"}))], lambda: ready.append(True))
    assert spin_until(lambda: talker.count_subscribers("said") == 1)
    assert not meeting.ready
    assert meeting.missing() == ["/listener"]
    heard = []
    listener.create_subscription(Int64, "said", heard.append, EVERY_TICK)
    assert spin_until(lambda: bool(ready))
    publisher.publish(Int64(data=7))
    assert spin_until(lambda: bool(heard))
    assert ready == [True]
