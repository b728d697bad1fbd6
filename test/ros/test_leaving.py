"""A node process ends with its own status, for any number of signals during the end."""

import signal
import subprocess

import pytest

pytest.importorskip("rclpy")

from ros_desk import LIMIT_S, process

pytestmark = pytest.mark.ros

LINGERS = """
import os, time
from rclpy.node import Node
from auv_ros.lifecycle import main_loop

class Lingers:
    def __del__(self, say=os.write, wait=time.sleep):
        say(1, b"leaving\\n")
        wait(1.0)

lingers = Lingers()  # Python deletes it at the very end

def make_nodes():
    os.write(1, b"up\\n")
    return [Node("lingers", enable_rosout=False)]

raise SystemExit(main_loop(make_nodes))
"""
UNHEARD = """
import os, time
from rclpy.node import Node
from auv_ros import lifecycle as node_main

node_main._HAND_OVER_S = 1000.0

class Publisher:
    topic_name = "/unheard"

    def __init__(self, word, is_heard):
        self.word, self.is_heard = word, is_heard

    def wait_for_all_acked(self, limit):
        if self.is_heard:
            os.write(1, self.word)
            return True
        time.sleep(limit.nanoseconds * 1e-9)
        return False

class Unheard(Node):
    exit_code = EXIT_CODE
    publishers = [Publisher(b"", False), Publisher(b"handed over\\n", True)]

def make_nodes():
    os.write(1, b"up\\n")
    return [Unheard("unheard", enable_rosout=False, start_parameter_services=False)]

raise SystemExit(node_main.main_loop(make_nodes))
"""
STEPPED = """
import os, threading, time
from rclpy.node import Node

wall_s, is_stepped = time.time, threading.Event()
time.time = lambda: wall_s() - 3600.0 * is_stepped.is_set()
from auv_ros.lifecycle import main_loop

class Endless(Node):
    exit_code = 3

    def on_stop(self):
        is_stepped.set()
        print("stopped", end="")

    def destroy_node(self):
        threading.Event().wait()

def make_nodes():
    os.write(1, b"up\\n")
    return [Endless("endless", enable_rosout=False, start_parameter_services=False)]

raise SystemExit(main_loop(make_nodes))
"""


@pytest.mark.parametrize("late", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_while_python_shuts_down_does_no_harm(late, tmp_path):
    (tmp_path / "lingers.py").write_text(LINGERS)
    with process("lingers", cwd=tmp_path) as child:
        assert child.stdout.readline() == "up\n"
        child.send_signal(signal.SIGINT)
        assert child.stdout.readline() == "leaving\n"
        child.send_signal(late)
        _, errors = child.communicate(timeout=LIMIT_S)
        assert (child.returncode, errors) == (0, "")


def test_a_sigterm_after_another_signal_ends_the_wait_for_readers_that_are_dead(tmp_path):
    (tmp_path / "unheard.py").write_text(UNHEARD.replace("EXIT_CODE", "0"))
    with process("unheard", cwd=tmp_path) as child:
        assert child.stdout.readline() == "up\n"
        child.send_signal(signal.SIGINT)
        assert child.stdout.readline() == "handed over\n"  # the reader that lives is not kept waiting
        child.send_signal(signal.SIGINT)  # as a terminal and a launcher send it at once: the wait goes on
        with pytest.raises(subprocess.TimeoutExpired):
            child.wait(0.5)
        child.send_signal(signal.SIGTERM)
        _, errors = child.communicate(timeout=LIMIT_S)
        assert (child.returncode, errors) == (0, "")


def test_a_node_of_a_lost_run_does_not_wait_long_for_readers_that_are_dead(tmp_path):
    (tmp_path / "unheard.py").write_text(UNHEARD.replace("EXIT_CODE", "3"))
    with process("unheard", cwd=tmp_path) as child:
        assert child.stdout.readline() == "up\n"
        child.send_signal(signal.SIGINT)
        _, errors = child.communicate(timeout=LIMIT_S)
        assert (child.returncode, errors) == (3, "")


def test_after_a_step_of_the_system_clock_nobody_waits_for_the_middleware_to_end(tmp_path):
    (tmp_path / "stepped.py").write_text(STEPPED)
    with process("stepped", cwd=tmp_path) as child:
        assert child.stdout.readline() == "up\n"
        child.send_signal(signal.SIGINT)
        output, errors = child.communicate(timeout=LIMIT_S)
        assert (child.returncode, output, errors) == (3, "stopped", "")
