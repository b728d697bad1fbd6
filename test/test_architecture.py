"""Claims about the whole source: where the wall clock and chance are, what files say."""

import ast
from pathlib import Path

from source_tree import FILES, NODES, PURE, imported_packages, tree_of

# People wait for these, or read their dates: they look at the wall clock. All else takes time as an argument.
WALL_CLOCK_FILES = {
    "auv_bag/link.py",
    "auv_bringup/launching/launcher.py",
    "auv_bringup/launching/node_start.py",
    "auv_bringup/launching/shared_memory.py",
    "auv_bringup/launching/status_listener.py",
    "auv_bringup/launching/supervision.py",
    "auv_bringup/tools/playback.py",
    "auv_bringup/tools/run.py",
    "auv_bringup/tools/topic.py",
    "auv_core/cli/progress.py",
    "auv_core/cli/tally.py",
    "auv_core/machine/processes.py",
    "auv_core/machine/workers.py",
    "auv_experiment/inprocess/evaluated_run.py",
    "auv_experiment/results.py",
    "auv_ros/lifecycle.py",
    "auv_ros/pace.py",
    "auv_ros/rendezvous.py",
    "auv_ros/run_watch.py",
    "auv_ros/steady_timer.py",
    "auv_thesis/cli.py",
    "auv_thesis/acoustics/estimators.py",
    "auv_thesis/laws/computing.py",
}
PLUGIN_FOLDERS = (
    "auv_control/allocation",
    "auv_control/controllers",
    "auv_control/courses",
    "auv_control/guidance/crab",
    "auv_control/guidance/paths",
    "auv_control/references",
    "auv_core/models",
    "auv_flocking/consensus",
    "auv_flocking/coordination",
    "auv_flocking/fleets",
    "auv_flocking/flocking",
    "auv_flocking/trackers",
    "auv_flocking/estimators",
    "auv_flocking/reports",
    "auv_flocking/separation",
    "auv_sim/acoustics/mac",
    "auv_sim/acoustics/modem",
    "auv_sim/acoustics/outage",
    "auv_sim/acoustics/propagation",
    "auv_sim/acoustics/sonar",
    "auv_sim/currents",
    "auv_sim/navigation",
    "auv_sim/obstacles",
)
SEEDED = {"default_rng", "Generator", "SeedSequence"}


def test_the_files_were_found():
    assert len(FILES) > 60
    assert set(FILES) >= WALL_CLOCK_FILES, "a file of the lists is gone"
    assert len(NODES) > 8


def _offenders(names, is_bad):
    """Return the names for which `is_bad` of their syntax tree holds."""
    return [name for name in names if is_bad(tree_of(name))]


def test_code_that_flies_never_names_the_simulator():
    flying = [name for name in FILES if name.startswith(("auv_control/", "auv_flocking/"))]
    assert [name for name in flying if "auv_sim" in FILES[name].read_text(encoding="utf-8")] == []


def test_time_comes_in_as_an_argument():
    def looks_at_a_clock(tree):
        return imported_packages(tree) & {"time", "datetime"}

    assert _offenders(set(FILES) - NODES - WALL_CLOCK_FILES, looks_at_a_clock) == []


def test_random_numbers_come_from_a_seed():
    def draws_from_anywhere(tree):
        numpys = [
            node.attr
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) in ("np.random", "numpy.random")
        ]
        others = imported_packages(tree) & {"random", "secrets", "uuid"}
        return others or set(numpys) - SEEDED

    assert _offenders(FILES, draws_from_anywhere) == []


def test_nothing_rests_on_pythons_salted_hash():
    def calls_hash(tree):
        return any(isinstance(node, ast.Call) and ast.unparse(node.func) == "hash" for node in ast.walk(tree))

    assert _offenders(PURE, calls_hash) == []


def test_every_module_says_what_it_is_for():
    assert _offenders(FILES, lambda tree: not ast.get_docstring(tree)) == []


def test_every_plugin_folder_says_how_to_add_to_it():
    folders = [f"{folder}/__init__.py" for folder in PLUGIN_FOLDERS]
    assert _offenders(folders, lambda tree: "To add" not in str(ast.get_docstring(tree))) == []


def test_there_is_no_drawer_for_everything():
    assert not {Path(name).stem for name in FILES} & {"utils", "util", "helpers", "misc", "common"}
