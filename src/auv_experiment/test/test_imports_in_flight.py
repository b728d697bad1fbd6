"""
A flight imports nothing: an import takes longer than a tick, and vehicles rest until it is over. Commands
import nothing that takes long and that their scenario does not need.
"""

import subprocess
import sys

import pytest

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


MAKE_AGENTS = """
import sys

from auv_experiment.compose import agent_configs
from auv_experiment.scenario.loading import load_scenario
from auv_flocking.agent import Agent

for name in sys.argv[1:]:
    for config in agent_configs(load_scenario(name)):
        Agent(config)
print("scipy" in sys.modules)
"""


@pytest.mark.parametrize(("scenario", "needs_scipy"), [("flock_acoustic", False), ("flock_sensed", True)])
def test_only_vehicles_with_a_sonar_load_scipy(scenario, needs_scipy):
    done = subprocess.run(
        [sys.executable, "-c", MAKE_AGENTS, scenario],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=True,
    )
    assert done.stdout == f"{needs_scipy}\n"
