"""A ROS node inside the test process, and child processes that are always ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from auv_bringup.launching.node_start import node_environment
from auv_ros.qos import own_qos

LIMIT_S = 30.0
_CLOCK_SHIFT = Path(__file__).with_name("clock_shift.c")


def domain_id() -> int:
    """Return the domain of this test process: the given one, or one that others are not likely to use."""
    return int(os.environ.setdefault("ROS_DOMAIN_ID", str(60 + os.getpid() % 40)))


def clock_library(folder: Path, *flags: str) -> Path:
    """Return the library, made in a folder, that shifts the system clock of a process that preloads it."""
    made = folder / "clock_shift.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", *flags, "-o", made, _CLOCK_SHIFT, "-ldl"], check=True)
    return made


def reliable(*, latched: bool = False) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


class Desk:
    """A node with its own context and executor."""

    def __init__(self) -> None:
        os.environ.update(node_environment(os.environ, domain_id=domain_id(), discovery="localhost"))
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain_id())
        self.node = rclpy.create_node("desk", context=self.context, enable_rosout=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def another_node(self, name, namespace=""):
        """Return one more node of the same process."""
        node = rclpy.create_node(name, namespace=namespace, context=self.context, enable_rosout=False)
        self.executor.add_node(node)
        return node

    def close(self) -> None:
        for node in self.executor.get_nodes():
            node.destroy_node()
        rclpy.shutdown(context=self.context)

    def publisher(self, kind, topic, *, latched=False):
        """Return a publisher that the nodes of a run hear."""
        return self.node.create_publisher(kind, topic, own_qos(latched=latched))

    def stranger(self, kind, topic):
        """Return a publisher as tools make them."""
        return self.node.create_publisher(kind, topic, 10)

    def listen(self, kind, topic, *, latched=False, raw=False) -> list:
        """Return the list that fills with the messages of a topic."""
        heard: list = []
        self.node.create_subscription(kind, topic, heard.append, reliable(latched=latched), raw=raw)
        return heard

    def until(self, condition, what: str, limit_s: float = LIMIT_S) -> None:
        """Spin until a condition holds."""
        deadline = time.monotonic() + limit_s
        while not condition():
            assert time.monotonic() < deadline, f"after {limit_s:g} s not yet: {what}"
            self.executor.spin_once(timeout_sec=0.02)


@contextmanager
def desk():
    """Give a desk for one test."""
    made = Desk()
    try:
        yield made
    finally:
        made.close()


@contextmanager
def process(*arguments: object, limits=None, cwd: Path | None = None):
    """Run a Python module as a process of its own; it is killed if the test leaves it running."""
    child = subprocess.Popen(
        [sys.executable, "-m", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain_id()), "PYTHONUNBUFFERED": "1"},
        preexec_fn=limits,
        cwd=cwd,
    )
    try:
        yield child
    finally:
        if child.poll() is None:
            child.kill()
        child.communicate(timeout=LIMIT_S)


def finish(child: subprocess.Popen, number: int | None = signal.SIGINT) -> tuple[int, str, str]:
    """Send a signal, or none, and return exit status, output and errors."""
    if number is not None:
        child.send_signal(number)
    out, err = child.communicate(timeout=LIMIT_S)
    return child.returncode, out, err
