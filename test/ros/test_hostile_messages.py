"""
Broken and absurd messages from a writer that offers what the run's own offer end no node and no report.

Foreign publishers that offer less are not heard at all (test_strangers.py); this test is about another
instance of our nodes, or a deliberate attack.
"""

import random
import signal
import struct
import sys
import threading
import time
from typing import Any

import pytest

pytest.importorskip("rclpy")

import yaml
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import serialize_message
from ros_desk import desk, process

from auv_bringup.launching.layout import process_specs
from auv_bringup.launching.node_specs import node_specs
from auv_bringup.launching.node_start import CONTAINER_MODULE, container_arguments, parts_of
from auv_core.messages import Inbox, Packet, Reception, SonarContact
from auv_experiment.recording_from_bag import read_recording
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_experiment.scenario.loading import load_scenario
from auv_msgs.msg import (
    AcousticInbox,
    AcousticOutbox,
    ControlStatus,
    FlockStatus,
    NeighbourEstimates,
    RecorderStatus,
    VehicleState,
)
from auv_ros.wire import conversions as convert
from auv_ros.wire.acoustics import inbox_bytes, outbox_bytes
from auv_ros.wire.commands import command_bytes

pytestmark = pytest.mark.ros

AT_ONCE = 250
PATIENCE_S = 30.0
ODD_NUMBERS = (0.0, -1.0, 1e-300, 1e9, -1e9, 1e300, float("inf"), float("-inf"), float("nan"))


def originals():
    """Return type and one good message by topic."""
    packet = Packet(3, 2, 0, 2, bytes(range(32)))
    inbox = Inbox(4, True, (Reception(packet, 0.1, 0.2, 9.0),) * 2, (SonarContact(5.0, 0.1, 0.2),) * 2)
    state = convert.state_stencil().filled(1.0, 7, True, True, *[0.5] * 15)
    wrench = command_bytes("auv_1", "wrench", 1.0, *[2.0] * 6)
    messages = {
        "/auv_1/nav": (VehicleState, state),
        "/auv_1/state": (VehicleState, state),
        "/auv_1/cmd_wrench": (WrenchStamped, wrench),
        "/auv_1/acoustic/rx": (AcousticInbox, inbox_bytes("auv_1", inbox, 1.0, 0)),
        "/auv_1/acoustic/tx": (AcousticOutbox, outbox_bytes("auv_1", 7, [packet, packet], 1.0)),
    }
    for topic, message in {
        "/auv_1/neighbours": NeighbourEstimates(),
        "/auv_1/control_status": ControlStatus(holding="words"),
        "/flock/status": FlockStatus(state=FlockStatus.RUNNING, lost_vehicles=["auv_2"]),
        "/recorder/status": RecorderStatus(ticks=3),
    }.items():
        messages[topic] = (type(message), bytes(serialize_message(message)))
    return messages


def mutated(rng, message):
    """Return a message with some of its bytes changed, numbers made odd, its end cut off or more added."""
    data = bytearray(message)
    for _ in range(rng.randint(1, 3)):
        kind, at = rng.randrange(6), rng.randrange(len(data) or 1)
        if kind == 0:
            del data[at:]
        elif kind == 1:
            data[at:at] = rng.randbytes(rng.randint(1, 9))
        elif kind == 2:
            data[at : at + 1] = rng.randbytes(1)
        elif kind == 3:
            at = max(4, len(data) - 8 * rng.randint(1, 16))
            data[at : at + 8] = struct.pack("<d", rng.choice(ODD_NUMBERS))
        elif kind == 4:
            data[at : at + 4] = rng.choice((b"\xff" * 4, b"\0" * 4, b"\0\0\0\x80"))
        else:
            data = bytearray(rng.randbytes(rng.randint(0, 200)))
    return bytes(data)


def pair(tmp_path):
    """Return two vehicles with modems and sonar."""
    raw = yaml.safe_load((SCENARIOS_DIR / "flock_acoustic.yaml").read_text())
    raw["vehicles"] = raw["vehicles"][:2]
    raw["answer_timeout_s"] = (
        PATIENCE_S  # so many messages at once keep a process of all nodes from its timers
    )
    path = tmp_path / "pair.yaml"
    path.write_text(yaml.safe_dump(raw))
    return load_scenario(str(path))


def told(statuses):
    """Return how often the clock has said that the flight moves; what is forged has no duration."""
    return sum(
        each.state == FlockStatus.RUNNING and each.duration_s == 650.0 and each.tick > 0 for each in statuses
    )


def bombard(tmp_path, count):
    """Fly two vehicles in real time in one process under `count` mutated messages on each topic."""
    scenario, rng, sent = pair(tmp_path), random.Random(5), 0
    specs = process_specs(node_specs(scenario, mode="realtime", bag_dir=tmp_path / "bag"), "single")
    (tmp_path / "params").mkdir()
    arguments = container_arguments(parts_of(specs[0], tmp_path / "params"))
    with desk() as at, process(CONTAINER_MODULE, *arguments) as nodes:
        errors = []
        listener = threading.Thread(target=lambda: errors.extend(nodes.stderr), daemon=True)
        listener.start()
        said = at.listen(FlockStatus, "/flock/status", latched=True)
        at.until(lambda: told(said), "the flight", 2.0 * PATIENCE_S)
        publishers = [
            (at.publisher(kind, topic, latched=topic == "/flock/status"), good)
            for topic, (kind, good) in originals().items()
        ]
        at.until(lambda: all(each.get_subscription_count() for each, _ in publishers), "the readers")
        while sent < count and nodes.poll() is None:
            for publisher, good in publishers:
                for _ in range(AT_ONCE):
                    publisher.publish(mutated(rng, good))
            sent += AT_ONCE
            said.clear()
            at.until(lambda: nodes.poll() is not None or told(said) > 1, "the flight goes on")
        is_alive = nodes.poll() is None
        nodes.send_signal(signal.SIGINT)
        status = nodes.wait(PATIENCE_S)
        listener.join(PATIENCE_S)
    text = "".join(errors)
    sys.stdout.write(f"{sent} messages on each of {len(publishers)} topics\n")
    assert is_alive, text[-3000:]
    assert "Traceback" not in text, text[-3000:]
    assert status == 0, text[-3000:]
    notes: list[Any] = []
    began_s = time.monotonic()
    recording = read_recording(tmp_path / "bag", scenario, notes.append)
    assert recording.n_ticks > 0
    assert time.monotonic() - began_s < PATIENCE_S + count / 500


def test_mutated_messages_end_nothing(tmp_path):
    bombard(tmp_path, AT_ONCE)


@pytest.mark.slow
@pytest.mark.timeout(3000)
def test_hundred_thousand_mutated_messages_on_each_topic_end_nothing(tmp_path):
    bombard(tmp_path, 100_000)
