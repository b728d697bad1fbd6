"""What pyproject.toml says of the wheel fits the source."""

import ast
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
FOLDERS = [ROOT / folder for folder in PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]]
DISTRIBUTIONS = {"yaml": "pyyaml", "skfuzzy": "scikit-fuzzy", "mpl_toolkits": "matplotlib"}
ROS = {"ament_index_python", "auv_msgs", "auv_ros", "builtin_interfaces", "diagnostic_msgs", "rclpy"}
ROS |= {"rosgraph_msgs", "rosidl_parser", "rosidl_runtime_py"}
OPTIONAL = {"distributed", "pelagic"}


def imported(folder):
    """Return what the modules of a folder import, its nodes left out as the wheel leaves them out."""
    found = set()
    for path in folder.rglob("*.py"):
        if "nodes" in path.relative_to(folder).parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                found.add(node.module.split(".")[0])
    return found - sys.stdlib_module_names


def test_the_wheel_holds_every_package_but_those_of_ros():
    packages = {path.parent.name for path in ROOT.glob("src/*/setup.py")}
    assert {folder.name for folder in FOLDERS} == packages - {"auv_ros"}


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_every_import_is_a_requirement_of_the_wheel_and_typed(folder):
    required = {line.split(">=")[0] for line in PROJECT["project"]["dependencies"]}
    ours = {each.name for each in FOLDERS}
    needed = {DISTRIBUTIONS.get(name, name) for name in imported(folder) - ours - ROS - OPTIONAL}
    assert needed <= required
    assert (folder / "py.typed").is_file()


def test_every_requirement_has_a_lower_bound():
    assert all(">=" in line for line in PROJECT["project"]["dependencies"])
