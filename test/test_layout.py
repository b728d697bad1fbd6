"""Claims about modules: the order of packages, no circles, where ROS is, what is too long or too full."""

import ast
import subprocess
import sys
from collections import Counter

import pytest
from source_tree import (
    FILES,
    MODULES,
    NODES,
    ORDER,
    PACKAGES,
    PURE,
    ROOT,
    SOURCE,
    imported_packages,
    imports_of,
    module_of,
    tree_of,
)

MOST_MODULES = 20
MOST_LINES = 350
ROS_SIDE = {"auv_ros", "auv_bringup"}
OF_ROS_SIDE = {"auv_msgs", "auv_ros"}
ROS = next(
    set(ast.literal_eval(statement.value))
    for statement in ast.parse((ROOT / "scripts" / "without_ros.py").read_text(encoding="utf-8")).body
    if isinstance(statement, ast.Assign)
)
"""What the tests without ROS hide."""


def allowed(name):
    """Return the packages that a file may import."""
    package = name.split("/")[0]
    above = set(ORDER[: ORDER.index(package) + 1])
    if name in NODES or package in ROS_SIDE:
        return above | OF_ROS_SIDE
    return above - OF_ROS_SIDE


def circle_in(graph):
    """Return a circle of a graph as a list, [] if there is none."""
    done: set[str] = set()
    path: list[str] = []

    def visit(module):
        if module in path:
            return [*path[path.index(module) :], module]
        if module in done:
            return []
        path.append(module)
        for other in sorted(graph[module]):
            if circle := visit(other):
                return circle
        done.add(path.pop())
        return []

    return next((circle for module in sorted(graph) if (circle := visit(module))), [])


def test_packages_import_only_those_above_them():
    wrong = {}
    for name in FILES:
        ours = imported_packages(tree_of(name)) & set(ORDER)
        if against := ours - allowed(name):
            wrong[name] = against
    assert wrong == {}


def test_a_package_of_the_wrong_order_would_be_found():
    assert "auv_sim" not in allowed("auv_flocking/agent.py")
    assert "auv_ros" in allowed("auv_flocking/nodes/agent_node.py")
    assert "auv_ros" not in allowed("auv_experiment/compose.py")
    assert "auv_bringup" not in allowed("auv_ros/lifecycle.py")


def test_no_modules_import_each_other_in_a_circle():
    graph = {
        module: {
            imported
            for imported, _ in imports_of(tree_of(name), type_checking=False)
            if imported in MODULES and imported != module
        }
        for module, name in MODULES.items()
    }
    assert circle_in(graph) == []


def test_a_circle_would_be_found():
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == ["b", "c", "b"]


def test_ros_is_named_only_where_it_may_be():
    """auv_bag asks for message types by name, when it needs them; others do not know ROS at all."""
    users = {name for name in FILES if imported_packages(tree_of(name)) & ROS}
    packages = {name.split("/")[0] for name in users - NODES}
    assert packages <= ROS_SIDE | {"auv_bag"}


def test_what_is_pure_imports_where_ros_is_absent():
    program = f"""
import importlib, sys
for package in {sorted(ROS)!r}:
    sys.modules[package] = None
sys.path[:0] = {[str(SOURCE / package) for package in PACKAGES]!r}
for module in {[module_of(name) for name in PURE]!r}:
    importlib.import_module(module)
print("all of them")
"""
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == "all of them"


def test_a_module_can_be_read_in_one_sitting():
    others = [*SOURCE.glob("*/launch/*.py"), *ROOT.glob("scripts/*.py"), *ROOT.glob("benchmarks/*.py")]
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in (*FILES.values(), *others)}
    assert {"launch", "scripts", "benchmarks"} <= {path.parent.name for path in lines}
    assert {str(path.relative_to(ROOT)): n for path, n in lines.items() if n > MOST_LINES} == {}


def test_a_folder_can_be_overlooked():
    modules = Counter(name.rpartition("/")[0] for name in FILES if not name.endswith("/__init__.py"))
    assert {folder: n for folder, n in modules.items() if n > MOST_MODULES} == {}


@pytest.mark.parametrize("package", ORDER)
def test_every_package_says_what_lives_there(package):
    text = (SOURCE / package / "README.md").read_text(encoding="utf-8")
    assert text.startswith(f"# {package}\n")
    assert "Start reading with" in text
    assert "import" in text
    assert len(text.splitlines()) <= 14
