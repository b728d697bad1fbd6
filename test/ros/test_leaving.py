"""A process of nodes leaves with its own status, however many signals it gets on the way out."""

import signal

import pytest

pytest.importorskip("rclpy")

from ros_desk import LIMIT_S, process

pytestmark = pytest.mark.ros

LINGERS = """
import os, time
from rclpy.node import Node
from auv_core.node_main import main_loop

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
