"""Makes bags of known content for the tests, with the type descriptions of the rosbags library."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from auv_bag.definitions import MessageType
from auv_bag.writer import BagWriter, Qos, Topic
from auv_core.params import Section, load_section

POINT = load_section({"kind": "kinematic", "params": {"hull_radius_m": 0.3}}, "model", "auv_core.models")
AUV_MSGS = Path(__file__).resolve().parents[2] / "src" / "auv_msgs" / "msg"


@cache
def typestore():
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for path in sorted(AUV_MSGS.glob("*.msg")):
        types.update(get_types_from_msg(path.read_text(), f"auv_msgs/msg/{path.stem}"))
    store.register(types)
    return store


@cache
def message_type(name: str) -> MessageType:
    definition, _ = typestore().generate_msgdef(name, ros_version=2)
    return MessageType(name, definition, typestore().hash_rihs01(name))


def make(name: str, /, **fields):
    return typestore().types[name](**fields)


def time(t_ns: int):
    return make("builtin_interfaces/msg/Time", sec=t_ns // 10**9, nanosec=t_ns % 10**9)


def header(t_ns: int, frame_id: str):
    return make("std_msgs/msg/Header", stamp=time(t_ns), frame_id=frame_id)


def vector(values):
    x, y, z = map(float, values)
    return make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def point(values):
    x, y, z = map(float, values)
    return make("geometry_msgs/msg/Point", x=x, y=y, z=z)


def twist(values):
    return make("geometry_msgs/msg/Twist", linear=vector(values[:3]), angular=vector(values[3:]))


def pose(position, quat_wxyz):
    w, x, y, z = map(float, quat_wxyz)
    orientation = make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
    return make("geometry_msgs/msg/Pose", position=point(position), orientation=orientation)


def random_message(name: str, rng: np.random.Generator):
    """Return a message of a type whose every string and sequence has a length of its own."""
    return make(name, **{field: _random(kind, rng) for field, kind in typestore().fielddefs[name][1]})


def _random(kind, rng: np.random.Generator):
    node, detail = kind
    if node == Nodetype.NAME:
        return random_message(detail, rng)
    if node == Nodetype.BASE:
        if detail[0] == "string":
            return "abcdefghi"[: rng.integers(0, 10)]
        return _random_numbers(detail[0], 1, rng)[0].item()
    element, count = detail[0], detail[1] if node == Nodetype.ARRAY else int(rng.integers(0, 4))
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        return _random_numbers(element[1][0], count, rng)
    return [_random(element, rng) for _ in range(count)]


def _random_numbers(kind: str, count: int, rng: np.random.Generator):
    if kind.startswith("float"):
        return rng.normal(size=count).astype(kind)
    return rng.integers(0, 2 if kind == "bool" else 100, size=count).astype(kind.replace("byte", "uint8"))


@dataclass(frozen=True)
class FakeVehicle:
    id: str
    model: Section = POINT


@dataclass(frozen=True)
class FakeScenario:
    """What the reader asks of a scenario."""

    vehicles: tuple[FakeVehicle, ...]
    period_s: float = 0.1
    command_max_age_s: float = 0.5
    ticks: int = 1000


def scenario(n: int, period_s: float = 0.1) -> Any:
    return FakeScenario(tuple(FakeVehicle(f"auv_{i + 1}") for i in range(n)), period_s)


class Recorder:
    """A BagWriter that takes message objects and registers topics on their first message."""

    def __init__(self, bag_dir: Path, latched=frozenset(), **options) -> None:
        self.writer = BagWriter(bag_dir, **options)
        self.latched = latched
        self.log: list[tuple[str, str, int, bytes]] = []
        self._channels: dict[str, int] = {}

    def write(self, topic: str, message, time_ns: int) -> None:
        name = message.__msgtype__
        if topic not in self._channels:
            qos = Qos(durability="transient_local" if topic in self.latched else "volatile")
            self._channels[topic] = self.writer.add_topic(Topic(topic, message_type(name), (qos,)))
        data = bytes(typestore().serialize_cdr(message, name))
        self.writer.write(self._channels[topic], data, time_ns)
        self.log.append((topic, name, time_ns, data))


class SyntheticRun:
    """A run of n vehicles over n_ticks whose every number is random but known."""

    def __init__(
        self, n: int, n_ticks: int, *, period_s: float = 0.1, epoch_ns: int = 0, seed: int = 0
    ) -> None:
        self.n, self.n_ticks, self.period_s, self.epoch_ns = n, n_ticks, period_s, epoch_ns
        rng = np.random.default_rng(seed)
        self.state = rng.normal(size=(n_ticks + 1, n, 13))
        self.command = rng.normal(size=(n_ticks, n, 6))
        self.reference = rng.normal(size=(n_ticks, n, 6))
        self.centre = rng.normal(size=(n_ticks, n, 6))
        self.neighbours = rng.normal(size=(n_ticks, n, n, 44))
        self.nav = rng.normal(size=(n_ticks + 1, n, 15))
        self.heard = rng.random((n_ticks, n)) < 0.8

    def time_ns(self, tick: float) -> int:
        return self.epoch_ns + round(tick * self.period_s * 1e9)

    def write(self, recorder: Recorder, *, extras: bool = False) -> None:
        for k in range(self.n_ticks + 1):
            t_ns = self.time_ns(k)
            recorder.write("/clock", make("rosgraph_msgs/msg/Clock", clock=time(t_ns)), t_ns)
            for i in range(self.n):
                self.write_state(recorder, k, i)
                if extras:
                    self._write_extras(recorder, k, i)
                if k < self.n_ticks:
                    self.write_decision(recorder, k, i)
            if k < self.n_ticks:
                self._write_events(recorder, k)

    def write_state(self, recorder: Recorder, k: int, i: int) -> None:
        truth = np.concatenate([self.state[k, i], [0.0, 0.0]])
        for topic, row in (("state", truth), ("nav", self.nav[k, i])):
            message = make(
                "auv_msgs/msg/VehicleState",
                header=header(self.time_ns(k), "map_ned"),
                tick=k,
                pose=pose(row[:3], row[3:7]),
                twist=twist(row[7:13]),
                valid=True,
                bounded=True,
                position_sd_m=float(row[13]),
                heading_sd_rad=float(row[14]),
            )
            recorder.write(f"/auv_{i + 1}/{topic}", message, self.time_ns(k))

    def write_decision(self, recorder: Recorder, k: int, i: int) -> None:
        t_ns, vehicle = self.time_ns(k), f"/auv_{i + 1}"
        wrench = make(
            "geometry_msgs/msg/Wrench",
            force=vector(self.command[k, i, :3]),
            torque=vector(self.command[k, i, 3:]),
        )
        body, world = header(t_ns, f"auv_{i + 1}/base_link_frd"), header(t_ns, "map_ned")
        recorder.write(
            f"{vehicle}/cmd_wrench", make("geometry_msgs/msg/WrenchStamped", header=body, wrench=wrench), t_ns
        )
        recorder.write(
            f"{vehicle}/reference",
            make("geometry_msgs/msg/TwistStamped", header=world, twist=twist(self.reference[k, i])),
            t_ns,
        )
        centre = self.centre[k, i]
        recorder.write(
            f"{vehicle}/flocking_centre",
            make(
                "auv_msgs/msg/FlockingCentre",
                header=world,
                tick=k,
                position=point(centre[:3]),
                velocity=vector(centre[3:]),
            ),
            t_ns,
        )
        recorder.write(
            f"{vehicle}/neighbours",
            make("auv_msgs/msg/NeighbourEstimates", header=world, tick=k, neighbours=self._estimates(k, i)),
            t_ns,
        )
        recorder.write(
            f"{vehicle}/acoustic/tx",
            make("auv_msgs/msg/AcousticOutbox", header=world, tick=k, packets=[self._packet(k, i)]),
            t_ns,
        )
        recorder.write(
            f"{vehicle}/acoustic/rx",
            make(
                "auv_msgs/msg/AcousticInbox",
                header=body,
                tick=k,
                transmit_ready=True,
                receptions=self._receptions(k, i),
                contacts=[self._contact(k, i)] if self.heard[k, i] else [],
            ),
            t_ns,
        )

    def _write_events(self, recorder: Recorder, k: int) -> None:
        events = [
            make(
                "auv_msgs/msg/AcousticEvent",
                outcome=0,
                source=i + 1,
                destination=0,
                sequence=k,
                start=time(self.time_ns(k)),
                end=time(self.time_ns(k + 0.5)),
                snr_db=float("nan"),
                size_bytes=2,
            )
            for i in range(self.n)
        ]
        message = make(
            "auv_msgs/msg/AcousticEvents", header=header(self.time_ns(k), ""), tick=k, events=events
        )
        recorder.write("/acoustic/events", message, self.time_ns(k))

    def _estimates(self, k: int, i: int):
        return [
            make(
                "auv_msgs/msg/NeighbourEstimate",
                address=j + 1,
                position=point(row[:3]),
                velocity=vector(row[3:6]),
                covariance=row[6:42].copy(),
                age_s=float(row[42]),
                sonar_age_s=float(row[43]),
            )
            for j, row in enumerate(self.neighbours[k, i])
            if j != i
        ]

    def _contact(self, k: int, i: int):
        range_m, bearing_rad, elevation_rad = map(float, self.nav[k, i, :3])
        return make(
            "auv_msgs/msg/SonarContact", range_m=range_m, bearing_rad=bearing_rad, elevation_rad=elevation_rad
        )

    def _packet(self, k: int, i: int):
        payload = np.frombuffer(bytes([k % 256, i]), np.uint8)
        return make(
            "auv_msgs/msg/AcousticPacket", tick=k, source=i + 1, destination=0, sequence=k, payload=payload
        )

    def _receptions(self, k: int, i: int):
        if k == 0 or not self.heard[k, i]:
            return []
        sender = (i + 1) % self.n
        return [
            make(
                "auv_msgs/msg/AcousticReception",
                packet=self._packet(k - 1, sender),
                sent=time(self.time_ns(k - 1)),
                arrival=time(self.time_ns(k - 0.25)),
                snr_db=float("nan"),
            )
        ]

    def _write_extras(self, recorder: Recorder, k: int, i: int) -> None:
        """Write the large messages that people look at."""
        t_ns, row = self.time_ns(k), self.state[k, i]
        odometry = make(
            "nav_msgs/msg/Odometry",
            header=header(t_ns, "map_ned"),
            child_frame_id="base",
            pose=make(
                "geometry_msgs/msg/PoseWithCovariance", pose=pose(row[:3], row[3:7]), covariance=np.zeros(36)
            ),
            twist=make(
                "geometry_msgs/msg/TwistWithCovariance", twist=twist(row[7:]), covariance=np.zeros(36)
            ),
        )
        recorder.write(f"/auv_{i + 1}/odom", odometry, t_ns)
        x, y, z = map(float, row[:3])
        transform = make(
            "geometry_msgs/msg/TransformStamped",
            header=header(t_ns, "map_ned"),
            child_frame_id=f"auv_{i + 1}",
            transform=make(
                "geometry_msgs/msg/Transform",
                translation=vector((x, y, z)),
                rotation=pose(row[:3], row[3:7]).orientation,
            ),
        )
        recorder.write("/tf", make("tf2_msgs/msg/TFMessage", transforms=[transform]), t_ns)
