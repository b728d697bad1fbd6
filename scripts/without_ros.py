"""
Pytest plugin that hides ROS 2: `pytest -p without_ros`, with this folder on PYTHONPATH.

The pure tests run under it, so that pure code that imports ROS, even indirectly, fails there on every
machine.
"""

import sys

ROS_MODULES = (
    "ament_index_python",
    "auv_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "launch",
    "launch_ros",
    "nav_msgs",
    "rcl_interfaces",
    "rclpy",
    "rosgraph_msgs",
    "rosidl_parser",
    "rosidl_runtime_py",
    "std_msgs",
    "tf2_msgs",
    "visualization_msgs",
)

# Python raises ModuleNotFoundError for a module that is None here.
for name in ROS_MODULES:
    sys.modules[name] = None  # type: ignore[assignment]
