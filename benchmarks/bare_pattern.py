"""
The comparison values of lock-step: its message pattern without any work.

Processes, nodes, topics, types and sizes of messages are those of a flock on a modem, and nodes wait for the
same nodes; but a node only publishes prepared messages, and the recorder only counts. There are two patterns:

* `plain`: messages and callbacks of rclpy, default middleware and scheduling;
* `lean`: bytes instead of messages, and our settings of middleware and scheduling. It is the smallest
  possible cost of our nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from visualization_msgs.msg import MarkerArray

from auv_bag.collector import TICKS_PER_BATCH
from auv_bag.ros_types import message_class
from auv_bag.topics import CLOCK_TOPIC, topics_of_graph
from auv_bringup.launching.node_specs import NodeSpec
from auv_core.messages import Inbox
from auv_ros.lifecycle import main_loop
from auv_ros.qos import EVERY_TICK, LATCHED
from auv_ros.rendezvous import Rendezvous
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.acoustics import inbox_bytes, outbox_bytes
from auv_ros.wire.commands import command_bytes
from auv_ros.wire.markers import HULL, MARKER_TICKS, sphere

RELAY = "/acoustic_relay_node"
DIAGNOSTIC_TICKS = 10


def message_bytes(vehicle_id: str, neighbours: int) -> dict[str, bytes]:
    """Return the bytes of a message of every topic that a node of a vehicle, or the relay, publishes."""
    name, serialised = vehicle_id, serialize_message
    state = convert.state_stencil().filled(0.0, *[0] * 17)
    odometry = convert.odometry_stencil("", "").filled(0.0, *[0] * 25)
    estimates = convert.neighbours_stencil(range(neighbours)).filled(
        0.0, 0, np.zeros((neighbours, convert.NEIGHBOUR_NUMBERS))
    )
    status = DiagnosticStatus(name=f"{name}/agent_node: neighbours", message="oldest packet 1.0 s")
    return {
        "state": state,
        "nav": state,
        "odom": odometry,
        "ground_truth/odom": odometry,
        "/tf": convert.motion_transforms(name).filled(0.0, [(0.0,) * 7] * 3),
        "cmd_wrench": command_bytes(name, "wrench", 0.0, *[0] * 6),
        "acoustic/tx": outbox_bytes(convert.body_frame(name), 0, [], 0.0),
        "acoustic/rx": inbox_bytes(convert.body_frame(name), Inbox(0, False, (), ()), 0.0, 0),
        "reference": convert.velocity_stencil().filled(0.0, *[0] * 6),
        "flocking_centre": convert.centre_stencil().filled(0.0, *[0] * 7),
        "neighbours": estimates,
        "/clock": serialised(Clock()),
        "/markers": serialised(MarkerArray(markers=[sphere(name, 0, 0.0, (0.0, 0.0, 0.0), 1.0, HULL)])),
        "/diagnostics": serialised(DiagnosticArray(status=[status, status])),
    }


class _BareNode(Node):
    """Waits for its listeners like our nodes."""

    def __init__(self, spec: NodeSpec, fleet: Sequence[str], *, is_lean: bool) -> None:
        super().__init__(spec.executable, namespace=spec.namespace)
        self._types = {
            topic.name: topic.type_name
            for topic in topics_of_graph(fleet, ["wrench"] * len(fleet), lockstep=True)
        }
        self._spoken = Topics(self, is_recorded=True)
        self._is_lean = is_lean

    def _publisher(self, topic: str, data: bytes, *listeners: str) -> Callable[[], None]:
        """Return the function that publishes a message with these bytes."""
        kind = self._kind(topic)
        spoken = self._spoken.add(kind, topic, heard_by=listeners)
        if self._is_lean:
            return partial(spoken.publish_bytes, data)
        return partial(spoken.publish, deserialize_message(data, kind))

    def _listen(self, topic: str, callback: Callable[[Any], None]) -> None:
        self.create_subscription(self._kind(topic), topic, callback, EVERY_TICK, raw=self._is_lean)

    def _meet(self, start: Callable[[], None]) -> None:
        self._meeting = Rendezvous(self, self._spoken, start)

    def _kind(self, topic: str) -> Any:
        full = topic if topic.startswith("/") else f"{self.get_namespace()}/{topic}"
        return message_class(self._types[full])


class BareVehicle(_BareNode):
    """Answers a command with state, navigation, odometry and transform."""

    def __init__(self, spec: NodeSpec, fleet: Sequence[str], *, is_lean: bool) -> None:
        super().__init__(spec, fleet, is_lean=is_lean)
        data = message_bytes(spec.vehicle_id, len(fleet) - 1)
        self._out = [
            self._publisher("nav", data["nav"], f"/{spec.vehicle_id}/agent_node"),
            self._publisher("state", data["state"], RELAY),
            self._publisher("odom", data["odom"]),
            self._publisher("/tf", data["/tf"]),
        ]
        self._seldom = [self._publisher(topic, data[topic]) for topic in ("ground_truth/odom", "/markers")]
        self._tick = 0
        self._listen("cmd_wrench", lambda _: self._answer())
        self._meet(self._answer)

    def _answer(self) -> None:
        for publish in self._out:
            publish()
        if self._tick % MARKER_TICKS == 0:
            for publish in self._seldom:
                publish()
        self._tick += 1


class BareAgent(_BareNode):
    """Answers a navigation and an inbox with command, outbox and neighbour estimates."""

    def __init__(self, spec: NodeSpec, fleet: Sequence[str], *, is_lean: bool) -> None:
        super().__init__(spec, fleet, is_lean=is_lean)
        data = message_bytes(spec.vehicle_id, len(fleet) - 1)
        self._out = [
            self._publisher("cmd_wrench", data["cmd_wrench"], f"/{spec.vehicle_id}/vehicle_node"),
            self._publisher("acoustic/tx", data["acoustic/tx"], RELAY),
            *(
                self._publisher(topic, data[topic])
                for topic in ("reference", "flocking_centre", "neighbours")
            ),
        ]
        self._rare = [
            (ticks, self._publisher(topic, data[topic]))
            for ticks, topic in ((MARKER_TICKS, "/markers"), (DIAGNOSTIC_TICKS, "/diagnostics"))
        ]
        self._heard = self._tick = 0
        self._is_ready = False
        for topic in ("nav", "acoustic/rx"):
            self._listen(topic, self._hear)
        self._meet(self._start)

    def _start(self) -> None:
        self._is_ready = True
        self._answer_if_due()

    def _hear(self, _: object) -> None:
        self._heard += 1
        self._answer_if_due()

    def _answer_if_due(self) -> None:
        if not self._is_ready or self._heard < 2:
            return
        self._heard -= 2
        for publish in self._out:
            publish()
        for ticks, publish in self._rare:
            if self._tick % ticks == 0:
                publish()
        self._tick += 1


class BareRelay(_BareNode):
    """The barrier: when all have answered, it begins the next tick and calls `on_tick`."""

    def __init__(
        self, spec: NodeSpec, fleet: Sequence[str], on_tick: Callable[[int], None], *, is_lean: bool
    ) -> None:
        super().__init__(spec, fleet, is_lean=is_lean)
        data = message_bytes(fleet[0], len(fleet) - 1)
        self._out = [self._publisher("/clock", data["/clock"])] + [
            self._publisher(f"/{name}/acoustic/rx", data["acoustic/rx"], f"/{name}/agent_node")
            for name in fleet
        ]
        self._markers = self._publisher("/markers", data["/markers"])
        self._owed, self._answers_per_tick = len(fleet), 2 * len(fleet)
        self._is_ready, self._tick, self._on_tick = False, 0, on_tick
        for name in fleet:
            for topic in ("state", "acoustic/tx"):
                self._listen(f"/{name}/{topic}", self._hear)
        self._meet(self._start)

    def _start(self) -> None:
        self._is_ready = True
        self._advance_if_due()

    def _hear(self, _: object) -> None:
        self._owed -= 1
        self._advance_if_due()

    def _advance_if_due(self) -> None:
        if not self._is_ready or self._owed:
            return
        self._owed = self._answers_per_tick
        self._on_tick(self._tick)
        for publish in self._out:
            publish()
        if self._tick % MARKER_TICKS == 0:
            self._markers()
        self._tick += 1


class BareRecorder(_BareNode):
    """Takes all messages, as many at once as our recorder, and keeps none."""

    def __init__(self, spec: NodeSpec, fleet: Sequence[str], *, is_lean: bool) -> None:
        super().__init__(spec, fleet, is_lean=is_lean)
        self._topics: list[Subscription] = []
        self._ticks = 0
        for topic in topics_of_graph(fleet, ["wrench"] * len(fleet), lockstep=True):
            qos = LATCHED if topic.latched else EVERY_TICK
            kind = message_class(topic.type_name)
            self._topics.append(self.create_subscription(kind, topic.name, self._hear_clock, qos, raw=True))

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """The clock's."""
        return (topic for topic in self._topics if topic.topic_name == CLOCK_TOPIC)

    def _hear_clock(self, _: bytes) -> None:
        self._ticks += 1
        if self._ticks % TICKS_PER_BATCH:
            return
        for topic in self._topics:
            while topic.topic_name != CLOCK_TOPIC and topic.handle.take_message(topic.msg_type, True):
                pass


def run(
    nodes: Sequence[NodeSpec], fleet: Sequence[str], on_tick: Callable[[int], None], *, is_lean: bool
) -> int:
    """Run as a process of these nodes; in that of the relay `on_tick` is called at every tick."""
    makers = {"vehicle": BareVehicle, "agent": BareAgent, "recorder": BareRecorder}

    def make() -> list[Node]:
        return [
            BareRelay(spec, fleet, on_tick, is_lean=is_lean)
            if spec.role == "relay"
            else makers[spec.role](spec, fleet, is_lean=is_lean)
            for spec in nodes
        ]

    return main_loop(make, ())
