"""Claims about the whole source: who imports what, where ROS and the wall clock are, how long files are."""

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src"
PACKAGES = ("auv_core", "auv_sim", "auv_control", "auv_flocking", "auv_bringup")
LONGEST_FILE = 450
# A flat list of figures, one function each, that nobody reads from end to end.
LONGER_FILES = {"auv_bringup/figures.py": 620}

# The arrows of docs/design.md: a package may import itself and these.
MAY_IMPORT = {
    "auv_core": set(),
    "auv_sim": {"auv_core"},
    "auv_control": {"auv_core"},
    "auv_flocking": {"auv_core", "auv_control"},
    "auv_bringup": {"auv_core", "auv_sim", "auv_control", "auv_flocking"},
}

ROS = {
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
}

# ROS is imported at the top of nodes and of these.
ROS_FILES = {
    f"auv_core/{name}.py"
    for name in (
        "conversions",
        "hearing",
        "markers",
        "node_main",
        "node_params",
        "qos",
        "run_watch",
        "stencil",
        "strangers",
        "transform_stencil",
    )
}
# ROS is imported only when a function that needs it runs: these import, and give their help, without ROS.
LAZY_ROS_FILES = {
    f"auv_bringup/{name}.py"
    for name in ("replay", "ros_environment", "ros_types", "status_listener", "topic")
}

# People wait for these, or read their dates: they look at the wall clock. All else takes time as an argument.
WALL_CLOCK_FILES = {"auv_core/node_main.py", "auv_core/run_watch.py", "auv_core/steady_timer.py"} | {
    f"auv_bringup/{name}.py"
    for name in (
        "bag_link",
        "cli",
        "flight",
        "launcher",
        "node_start",
        "processes",
        "progress",
        "replay",
        "shared_memory",
        "reproduction/cli",
        "status_listener",
        "results",
        "supervision",
        "tally",
        "topic",
        "workers",
    )
}
SEEDED = {"default_rng", "Generator", "SeedSequence"}


def _name(path):
    """Return ``auv_core/models/six_dof.py`` for a file of a package."""
    return path.relative_to(SOURCE / path.relative_to(SOURCE).parts[0]).as_posix()


FILES = {
    _name(path): path for package in PACKAGES for path in sorted((SOURCE / package / package).rglob("*.py"))
}
NODES = {name for name in FILES if "/nodes/" in name and not name.endswith("__init__.py")}
PURE = sorted(set(FILES) - NODES - ROS_FILES)


@cache
def _tree(name):
    return ast.parse(FILES[name].read_text(encoding="utf-8"))


def _imports(tree):
    """Return (top-level package, node) of every import below a node, type checking included."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(alias.name.split(".")[0], node) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            found.append((node.module.split(".")[0], node))
    return found


def _eager_imports(tree):
    """Return the packages that importing the file imports: not those in functions nor for type checking."""
    eager, waiting = set(), list(tree.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            eager |= {package for package, _ in _imports(node)}
        waiting += ast.iter_child_nodes(node)
    return eager


def _module(name):
    return name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def test_the_files_were_found():
    assert len(FILES) > 60
    assert set(FILES) >= ROS_FILES | LAZY_ROS_FILES | WALL_CLOCK_FILES, "a file of the lists is gone"
    assert len(NODES) == 9


def _offenders(names, is_bad):
    """Return the names for which `is_bad` of their syntax tree holds."""
    return [name for name in names if is_bad(_tree(name))]


def test_imports_follow_the_arrows():
    wrong = {}
    for name in FILES:
        package = name.split("/")[0]
        ours = {imported for imported, _ in _imports(_tree(name)) if imported in PACKAGES}
        if against := ours - MAY_IMPORT[package] - {package}:
            wrong[name] = against
    assert wrong == {}


def test_code_that_flies_never_names_the_simulator():
    flying = [name for name in FILES if name.startswith(("auv_control/", "auv_flocking/"))]
    assert [name for name in flying if "auv_sim" in FILES[name].read_text(encoding="utf-8")] == []


def test_ros_is_not_imported_with_pure_modules():
    assert _offenders(PURE, lambda tree: _eager_imports(tree) & ROS) == []


def test_ros_is_named_only_where_it_may_be():
    users = {name for name in FILES if {imported for imported, _ in _imports(_tree(name))} & ROS}
    assert users <= NODES | ROS_FILES | LAZY_ROS_FILES
    assert users >= ROS_FILES | LAZY_ROS_FILES, "a file that no longer needs ROS is still in the list"


def test_pure_modules_import_where_ros_is_absent():
    program = f"""
import importlib, sys
for package in {sorted(ROS)!r}:
    sys.modules[package] = None
sys.path[:0] = {[str(SOURCE / package) for package in PACKAGES]!r}
for module in {[_module(name) for name in PURE]!r}:
    importlib.import_module(module)
print("all of them")
"""
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == "all of them"


def test_time_comes_in_as_an_argument():
    def looks_at_a_clock(tree):
        return {imported for imported, _ in _imports(tree)} & {"time", "datetime"}

    assert _offenders(set(FILES) - NODES - WALL_CLOCK_FILES, looks_at_a_clock) == []


def test_random_numbers_come_from_a_seed():
    def draws_from_anywhere(tree):
        numpys = [
            node.attr
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) in ("np.random", "numpy.random")
        ]
        others = {imported for imported, _ in _imports(tree)} & {"random", "secrets", "uuid"}
        return others or set(numpys) - SEEDED

    assert _offenders(FILES, draws_from_anywhere) == []


def test_nothing_rests_on_pythons_salted_hash():
    def calls_hash(tree):
        return any(isinstance(node, ast.Call) and ast.unparse(node.func) == "hash" for node in ast.walk(tree))

    assert _offenders(PURE, calls_hash) == []


def test_every_module_says_what_it_is_for():
    assert _offenders(FILES, lambda tree: not ast.get_docstring(tree)) == []


def test_every_plugin_folder_says_how_to_add_to_it():
    folders = [name for name in FILES if name.endswith("/__init__.py") and name.count("/") > 1]
    no_plugins = {
        "auv_sim/acoustics/__init__.py",
        "auv_bringup/reproduction/__init__.py",
        "auv_bringup/sweeps/__init__.py",
    }
    folders = [name for name in folders if "/nodes/" not in name and name not in no_plugins]
    assert len(folders) == 13
    assert _offenders(folders, lambda tree: "To add" not in ast.get_docstring(tree)) == []


def test_no_file_is_too_long_to_read_in_one_sitting():
    lengths = {name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in FILES.items()}
    long = {name: n for name, n in lengths.items() if n > LONGER_FILES.get(name, LONGEST_FILE)}
    assert long == {}


def test_there_is_no_drawer_for_everything():
    assert not {Path(name).stem for name in FILES} & {"utils", "util", "helpers", "misc", "common"}
