"""Which Python modules a message type's name may import."""

import sys

import pytest

pytest.importorskip("rclpy")

from nav_msgs.msg import Odometry

from auv_bag.ros_types import message_class
from auv_bag.writer import BagError
from auv_msgs.msg import VehicleState

pytestmark = pytest.mark.ros


def test_installed_types_are_found():
    assert message_class("nav_msgs/msg/Odometry") is Odometry
    assert message_class("auv_msgs/msg/VehicleState") is VehicleState


@pytest.mark.parametrize(
    "name",
    [
        "trap/msg/Trap",  # a module of the current folder
        "trap/Trap",
        "trap",
        "os/system",
        "std_msgs/msg/Nothing",
        "std_msgs/msg/_string",
        "../trap/msg/Trap",
        "std_msgs/msg/String/../../trap",
        "x\x1b[2J\n/msg/Y",
        "",
    ],
)
def test_a_name_from_a_file_imports_nothing(name, tmp_path, monkeypatch):
    (tmp_path / "trap" / "msg").mkdir(parents=True)
    for folder in ("trap", "trap/msg"):
        (tmp_path / folder / "__init__.py").write_text("raise SystemExit('code from data')")
    monkeypatch.syspath_prepend(tmp_path)
    before = set(sys.modules)
    with pytest.raises(BagError, match="is not installed here") as error:
        message_class(name)
    assert "\n" not in str(error.value)
    assert not [module for module in set(sys.modules) - before if module.startswith(("trap", "os."))]
