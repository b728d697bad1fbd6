"""A flight imports nothing: an import takes longer than a tick, and vehicles rest until it is over."""

import subprocess
import sys

FLY_ALL = """
import sys
from dataclasses import replace

from auv_core.compiled import use_compiler
from auv_experiment.inprocess.stepwise import StepwiseRun
from auv_experiment.scenario.loading import list_scenarios, load_scenario

use_compiler()
for name, _ in list_scenarios():
    run = StepwiseRun(replace(load_scenario(name), sampling="sampled"))
    ready = set(sys.modules)
    for _ in range(60):
        run.act(run.decide())
    imported = sorted(set(sys.modules) - ready)
    if imported:
        print(f"{name} imports {len(imported)} modules in flight: {', '.join(imported[:9])}")
"""
"""In a process of its own, where no other test has imported anything. Packets come from tick 4 on."""


def test_no_scenario_imports_a_module_once_it_flies():
    done = subprocess.run(
        [sys.executable, "-c", FLY_ALL], capture_output=True, text=True, timeout=200.0, check=True
    )
    assert done.stdout == ""
