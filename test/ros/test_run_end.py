"""Claim: only the clock of its own run can end a node, whatever else arrives on /flock/status."""

from functools import partial
from typing import Any

import pytest

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Time
from ros_desk import desk
from std_msgs.msg import Header

from auv_msgs.msg import FlockStatus
from auv_ros import run_watch
from auv_ros.run_watch import RunEnd

pytestmark = pytest.mark.ros

EPOCH_S = 1_800_000_000


def status(state, time_s, *, epoch_s=EPOCH_S, duration_s=30.0):
    header = Header(stamp=Time(sec=epoch_s + int(time_s)))
    return FlockStatus(
        header=header, state=state, tick=int(10 * time_s), time_s=time_s, duration_s=duration_s
    )


def publish(at, publisher, seen, message):
    """Publish a status and wait until all subscribers have it."""
    count = len(seen)
    publisher.publish(message)
    at.until(lambda: len(seen) > count, message.state)
    for _ in range(3):
        at.executor.spin_once(timeout_sec=0.0)


@pytest.mark.parametrize(
    "forged",
    [
        FlockStatus(state=FlockStatus.FINISHED),
        status(FlockStatus.FINISHED, 12.0),
        status(FlockStatus.FINISHED, 30.0, epoch_s=EPOCH_S + 7),
        status(FlockStatus.FINISHED, 200.0, duration_s=200.0),
        status(FlockStatus.ABORTED, 12.0, epoch_s=EPOCH_S - 60),
        status(FlockStatus.ABORTED, 3.0),
    ],
)
@pytest.mark.parametrize("own", [status(FlockStatus.FINISHED, 30.0), status(FlockStatus.ABORTED, 12.0)])
def test_only_the_end_of_the_own_run_ends_a_node(forged, own):
    with desk() as at:
        ends: list[Any] = []
        warnings: list[str] = []
        at.node.on_run_end = lambda: ends.append(None)
        at.node.get_logger().warning = warnings.append
        RunEnd([at.node])
        publisher = at.publisher(FlockStatus, "/flock/status", latched=True)
        at.until(lambda: publisher.get_subscription_count() == 1, "the node hears")
        seen = at.listen(FlockStatus, "/flock/status")

        say = partial(publish, at, publisher, seen)
        say(status(FlockStatus.WAITING, 0.0, epoch_s=0))
        say(status(FlockStatus.RUNNING, 10.0))
        say(forged)
        say(forged)
        assert not ends
        assert len(warnings) == 1
        assert "another run publishes it; ignored" in warnings[0]
        say(own)
        at.until(lambda: len(ends) == 1, "the run ends")


def test_an_end_after_which_the_run_goes_on_ends_no_node(monkeypatch):
    monkeypatch.setattr(run_watch, "_GRACE_S", 0.0)
    with desk() as at:
        warnings: list[Any] = []
        at.node.get_logger().warning = warnings.append
        run_end = RunEnd([at.node])
        publisher = at.publisher(FlockStatus, "/flock/status", latched=True)
        at.until(lambda: publisher.get_subscription_count() == 1, "the node hears")
        say = partial(publish, at, publisher, at.listen(FlockStatus, "/flock/status"))
        say(status(FlockStatus.RUNNING, 10.0))
        assert not run_end.is_past()
        say(status(FlockStatus.ABORTED, 20.0))
        assert (run_end.is_past(), run_end.is_lost) == (True, True)
        assert warnings == []
        say(status(FlockStatus.RUNNING, 11.0))
        assert (run_end.is_past(), run_end.is_lost) == (False, False)
        assert "says aborted at 20 of 30 s" in warnings[0]
        say(status(FlockStatus.FINISHED, 30.0))
        assert (run_end.is_past(), run_end.is_lost) == (True, False)


def test_an_end_before_the_first_word_of_the_run_ends_no_node_either(monkeypatch):
    monkeypatch.setattr(run_watch, "_GRACE_S", 0.0)
    with desk() as at:
        run_end = RunEnd([at.node])
        publisher = at.publisher(FlockStatus, "/flock/status", latched=True)
        at.until(lambda: publisher.get_subscription_count() == 1, "the node hears")
        say = partial(publish, at, publisher, at.listen(FlockStatus, "/flock/status"))
        say(status(FlockStatus.WAITING, 0.0, epoch_s=0))
        say(status(FlockStatus.FINISHED, 30.0))
        assert run_end.is_past()
        say(status(FlockStatus.RUNNING, 1.0))
        assert not run_end.is_past()


def test_the_process_of_the_clock_believes_no_end_but_its_own():
    with desk() as at:
        ends: list[Any] = []
        warnings: list[str] = []
        at.node.on_run_end = lambda: ends.append(None)
        at.node.get_logger().warning = warnings.append
        publisher = at.publisher(FlockStatus, "/flock/status", latched=True)
        RunEnd([at.node])
        at.until(lambda: publisher.get_subscription_count() == 1, "the node hears")
        say = partial(publish, at, publisher, at.listen(FlockStatus, "/flock/status"))
        say(status(FlockStatus.RUNNING, 10.0))
        say(status(FlockStatus.FINISHED, 30.0))
        assert len(warnings) == 1
        assert not ends
        at.node.done = True
        say(status(FlockStatus.FINISHED, 30.0))
        at.until(lambda: ends, "the run ends")
