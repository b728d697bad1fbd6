"""
The limit beside which the lock-step rate is quoted: the same processes, one small message out, one back,
nothing else.

`measure(workers, ticks)` starts that many worker processes; each answers every tick of the coordinator with
one Int64.
"""

from __future__ import annotations

import subprocess
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Int64

from auv_core.node_main import EVERY_TICK, Audience, Rendezvous, main_loop, make_executor

_LIMIT_S = 120.0


class Worker(Node):
    """Answers every tick."""

    def __init__(self, number: int) -> None:
        super().__init__(f"worker_{number}")
        self._pub = self.create_publisher(Int64, "answer", EVERY_TICK)
        self.create_subscription(Int64, "tick", self._pub.publish, EVERY_TICK)


class Coordinator(Node):
    """Sends a tick when all have answered the one before."""

    def __init__(self, workers: int, ticks: int) -> None:
        super().__init__("coordinator")
        self.finished = Future()
        self.elapsed_s = 0.0
        self._workers, self._ticks = workers, ticks
        self._tick, self._answers, self._started_s = 0, 0, 0.0
        self._pub = self.create_publisher(Int64, "tick", EVERY_TICK)
        self.create_subscription(Int64, "answer", self._on_answer, EVERY_TICK)
        names = frozenset(f"/worker_{number}" for number in range(workers))
        self._meeting = Rendezvous(self, [Audience(self._pub, names)], self._start)

    def _start(self) -> None:
        self._started_s = time.monotonic()
        self._pub.publish(Int64(data=0))

    def _on_answer(self, message: Int64) -> None:
        self._answers += 1
        if self._answers < self._workers:
            return
        self._answers = 0
        self._tick += 1
        if self._tick < self._ticks:
            self._pub.publish(Int64(data=self._tick))
        else:
            self.elapsed_s = time.monotonic() - self._started_s
            self.finished.set_result(True)


def measure(workers: int, ticks: int) -> float:
    """Return ticks per second of a bare barrier over `workers` processes."""
    commands = [[sys.executable, __file__, str(number)] for number in range(workers)]
    processes = [subprocess.Popen(command) for command in commands]
    rclpy.init()
    node = Coordinator(workers, ticks)
    executor = make_executor()
    executor.add_node(node)
    try:
        executor.spin_until_future_complete(node.finished, timeout_sec=_LIMIT_S)
        if not node.elapsed_s:
            raise TimeoutError(f"the bare barrier did not finish within {_LIMIT_S:g} s")
        return ticks / node.elapsed_s
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait(timeout=10.0)
        node.destroy_node()
        rclpy.shutdown()


if __name__ == "__main__":
    raise SystemExit(main_loop(lambda: [Worker(int(sys.argv[1]))]))
