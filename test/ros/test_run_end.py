"""Claim: who may end a node is the clock of its own run, whatever else arrives on /flock/status."""

import pytest

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Time
from ros_desk import desk
from std_msgs.msg import Header

from auv_core.run_watch import RunEnd
from auv_msgs.msg import FlockStatus

pytestmark = pytest.mark.ros

EPOCH_S = 1_800_000_000


def status(state, time_s, *, epoch_s=EPOCH_S, duration_s=30.0):
    header = Header(stamp=Time(sec=epoch_s + int(time_s)))
    return FlockStatus(
        header=header, state=state, tick=int(10 * time_s), time_s=time_s, duration_s=duration_s
    )


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
        ends, warnings = [], []
        at.node.on_run_end = lambda: ends.append(None)
        at.node.get_logger().warning = warnings.append
        RunEnd([at.node])
        publisher = at.publisher(FlockStatus, "/flock/status", latched=True)
        at.until(lambda: publisher.get_subscription_count() == 1, "the node hears")
        seen = at.listen(FlockStatus, "/flock/status")

        def say(message):
            count = len(seen)
            publisher.publish(message)
            at.until(lambda: len(seen) > count, message.state)
            for _ in range(3):
                at.executor.spin_once(timeout_sec=0.0)

        say(status(FlockStatus.WAITING, 0.0, epoch_s=0))
        say(status(FlockStatus.RUNNING, 10.0))
        say(forged)
        say(forged)
        assert not ends
        assert len(warnings) == 1
        assert "another run publishes it; not believed" in warnings[0]
        say(own)
        at.until(lambda: len(ends) == 1, "the run ends")
