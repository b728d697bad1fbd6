"""Claims about the timers of nodes: in the executor's thread, not piled up, ended by an exception."""

import queue
import threading
import time
from types import SimpleNamespace
from typing import Any

import pytest

from auv_ros.steady_timer import SteadyTimer

LIMIT_S = 10.0


class Executor:
    """Runs what it is given when a test asks for it."""

    def __init__(self):
        self.tasks: queue.Queue[Any] = queue.Queue()

    def create_task(self, call):
        self.tasks.put(call)

    def run_next(self):
        self.tasks.get(timeout=LIMIT_S)()


@pytest.fixture
def node():
    return SimpleNamespace(executor=Executor())


@pytest.fixture
def start(node):
    timers = []

    def begin(period_s, callback):
        timers.append(SteadyTimer(node, period_s, callback))
        return timers[-1]

    yield begin
    for timer in timers:
        timer.cancel()


def test_calls_come_once_a_period_in_the_thread_of_the_executor(node, start):
    calls = []
    began_s = time.monotonic()
    start(0.02, lambda: calls.append((time.monotonic(), threading.current_thread())))
    for _ in range(5):
        node.executor.run_next()
    assert {thread for _, thread in calls} == {threading.current_thread()}
    assert all(at_s >= began_s + 0.02 * (k + 1) for k, (at_s, _) in enumerate(calls))


def test_an_executor_that_is_busy_finds_one_call_and_not_many(node, start):
    other = start(0.01, lambda: None)
    counted = []
    start(0.01, lambda: counted.append(1))
    other.cancel()
    deadline_s = time.monotonic() + LIMIT_S
    while node.executor.tasks.empty():
        assert time.monotonic() < deadline_s
        time.sleep(0.001)
    time.sleep(0.1)
    assert node.executor.tasks.qsize() <= 2  # the other one may have come before it was cancelled


def test_an_exception_ends_the_timer_and_is_kept_for_who_runs_the_node(node, start):
    def fail():
        raise ValueError("no")

    start(0.01, fail)
    node.executor.run_next()
    assert isinstance(node.timer_error, ValueError)
    with pytest.raises(queue.Empty):
        node.executor.tasks.get(timeout=0.1)


def test_nothing_is_called_before_there_is_an_executor_and_after_the_end():
    node = SimpleNamespace(executor=None)
    timer = SteadyTimer(node, 0.005, lambda: None)
    time.sleep(0.03)
    node.executor = Executor()
    node.executor.run_next()
    timer.cancel()
    while not node.executor.tasks.empty():
        node.executor.tasks.get()
    time.sleep(0.05)
    assert node.executor.tasks.empty()
