"""
A process in the place of a node, for tests of the launcher: python fake_node.py NOTES NAME BEHAVIOUR [NUMBER]

It writes the names of what happens to the file NOTES, a line each. Behaviours:

    idle            wait for SIGINT, then end with status 0
    stubborn        ignore SIGINT and SIGTERM
    hand_over       after SIGINT wait for SIGTERM, then end with status 0
    die             say something, end with status 7
    fly             publish /flock/status as the clock does, of a flight of NUMBER seconds, and leave
    abort           the same, but end the flight as lost
    leave           publish that the flight runs, then end with status 0
    lose            give up auv_2 on the way, and finish
"""

import os
import signal
import sys
import threading

notes, name, behaviour = sys.argv[1:4]
duration_s = float(sys.argv[4]) if len(sys.argv) > 4 else 0.0
PERIOD_S = 0.1
stop = threading.Event()
pause = threading.Event()


def note(word: str) -> None:
    with open(notes, "a", encoding="utf-8") as stream:  # noqa: PTH123
        stream.write(f"{word} {name}\n")


def status_publisher():
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    from auv_msgs.msg import FlockStatus
    from auv_ros.qos import LATCHED
    from auv_ros.run_config import LOCKSTEP_EPOCH_S
    from auv_ros.wire import conversions as convert

    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("clock_node")
    publisher = node.create_publisher(FlockStatus, "/flock/status", LATCHED)

    def publish(state: str, time_s: float, **more) -> None:
        stamp_s = 0.0 if state == "waiting" else LOCKSTEP_EPOCH_S + time_s
        header = convert.header(stamp_s, "")
        publisher.publish(
            FlockStatus(header=header, state=state, time_s=time_s, duration_s=duration_s, **more)
        )

    return publisher, publish


def fly() -> int:
    """Publish as the clock does, until it leaves; return its exit status."""
    publisher, publish = status_publisher()
    publish("waiting", 0.0, waiting_for=["/auv_1/agent_node"])
    while not stop.is_set() and not publisher.get_subscription_count():
        pause.wait(0.01)  # a flight of a second could be over before the launcher has found it
    tick, status = 0, 0
    lost: list[str] = []
    while not stop.is_set() and tick * PERIOD_S < duration_s:
        time_s = tick * PERIOD_S
        publish("running", time_s, lost_vehicles=lost)
        if behaviour == "leave" and time_s > 0.5:
            return 0
        if behaviour == "abort" and time_s > 0.5:
            publish("aborted", time_s, detail="/auv_1/agent_node: no answer for tick 5 within 3 s")
            status = 3
            break
        if behaviour == "lose" and time_s > 0.5:
            lost = ["auv_2"]
        tick += 1
        pause.wait(0.05)
    else:
        publish("finished", duration_s, lost_vehicles=lost)
    publisher.wait_for_all_acked()
    return status


signal.signal(signal.SIGINT, lambda *_: stop.set())
if behaviour == "stubborn":
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
if behaviour == "hand_over":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
note("started")
sys.stdout.write(f"{name} with pid {os.getpid()}\n")
sys.stdout.flush()
if behaviour == "die":
    sys.stdout.write("something is wrong\n")
    sys.exit(7)
if behaviour in ("idle", "stubborn", "hand_over"):
    stop.wait(60.0)
    status = 0
else:
    status = fly()
note("ended")
os._exit(status)
