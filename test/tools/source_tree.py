"""The source of the packages, for tests that make claims about all of it."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src"

# The order of docs/explanation/design.md: a package may import itself and those before it.
ORDER = (
    "auv_msgs",
    "auv_core",
    "auv_control",
    "auv_flocking",
    "auv_sim",
    "auv_ros",
    "auv_bag",
    "auv_experiment",
    "auv_thesis",
    "auv_bringup",
    "shoal",
)
PACKAGES = ORDER[1:]


def _name(path):
    """Return ``auv_core/models/six_dof.py`` for a file of a package."""
    return path.relative_to(SOURCE / path.relative_to(SOURCE).parts[0]).as_posix()


FILES = {
    _name(path): path for package in PACKAGES for path in sorted((SOURCE / package / package).rglob("*.py"))
}
NODES = {name for name in FILES if "/nodes/" in name and not name.endswith("__init__.py")}
PURE = sorted(name for name in FILES if name not in NODES and not name.startswith("auv_ros/"))
"""
What imports without ROS. That auv_bringup does is more than its place asks: `run --mode inprocess` needs
it.
"""


def module_of(name):
    return name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


MODULES = {module_of(name): name for name in FILES}


@cache
def tree_of(name):
    return ast.parse(FILES[name].read_text(encoding="utf-8"))


def imports_of(tree, *, type_checking=True):
    """Return (module or name, node) of every import below a node, those in functions included."""
    found: list[tuple[str, ast.Import | ast.ImportFrom]] = []
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test) and not type_checking:
            waiting += node.orelse
            continue
        if isinstance(node, ast.Import):
            found += [(alias.name, node) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            full = [f"{node.module}.{alias.name}" for alias in node.names]
            found += [(each if each in MODULES else str(node.module), node) for each in full]
        waiting += ast.iter_child_nodes(node)
    return found


def imported_packages(tree):
    return {module.split(".")[0] for module, _ in imports_of(tree)}
