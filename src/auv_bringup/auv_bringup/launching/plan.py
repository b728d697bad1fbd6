"""
The plan of a run: a scenario and how to fly it, validated before anything is started or written.

The run command and the launch file both start with it.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from auv_bringup.launching.layout import check_layout
from auv_core.machine.whole_files import write_text
from auv_core.params import ConfigError
from auv_experiment import results

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

DEFAULT_SCENARIO = "flock_acoustic"
ROS_MODES = ("lockstep", "realtime")
MODES = (*ROS_MODES, "inprocess")


@dataclass(frozen=True)
class Plan:
    """
    A validated run.

    `layout` groups nodes into processes; it is not part of the scenario, since no number depends on it.
    `overrides` and `duration_s` are the user's changes to the scenario's file; `is_switched` tells that a
    continuous scenario is flown sampled, since nodes can only sample.
    """

    scenario: Scenario
    mode: str
    layout: str
    overrides: tuple[str, ...]
    duration_s: float | None
    is_switched: bool

    @property
    def name(self) -> str:
        """Name of the results folder, without the suffix that tells repeated runs apart."""
        digest = results.overrides_hash(self.overrides, self.duration_s)
        return results.results_name(self.scenario.name, self.scenario.seed, self.mode, digest)


def make_plan(
    name_or_path: str,
    *,
    mode: str | None = None,
    layout: str | None = None,
    seed: int | None = None,
    overrides: Sequence[str] = (),
    duration_s: float | None = None,
    discovery: str = "localhost",
) -> Plan:
    """
    Validate a run.

    Parameters
    ----------
    name_or_path : str
        Scenario, as for `load_scenario`.
    mode : str, optional
        One of `MODES`; by default lockstep, and inprocess for a continuous scenario.
    layout : str, optional
        One of `layout.LAYOUTS`, for a mode with nodes.
    seed, overrides, duration_s
        As for `load_scenario`.
    discovery : str
        'localhost' or 'subnet'; on one machine few processes find each other.

    Raises
    ------
    ConfigError
        With one line for the user.

    """
    from auv_experiment.run_memory import check_memory  # late: this imports all code for flights
    from auv_experiment.scenario.loading import load_scenario

    if duration_s is not None and not math.isfinite(duration_s):
        raise ConfigError(f"--duration {duration_s!r} is not allowed; allowed: a finite number of seconds")
    scenario = load_scenario(name_or_path, overrides=overrides, seed=seed, duration_s=duration_s)
    is_continuous = scenario.sampling == "continuous"
    mode = mode or ("inprocess" if is_continuous else "lockstep")
    is_switched = is_continuous and mode in ROS_MODES
    if is_switched:
        scenario = replace(scenario, sampling="sampled")
    layout = check_layout(
        layout,
        mode=mode,
        on_vehicle_loss=scenario.on_vehicle_loss,
        vehicles=len(scenario.vehicles),
        discovery=discovery,
    )
    check_memory(scenario, has_nodes=mode in ROS_MODES)
    return Plan(scenario, mode, layout, tuple(overrides), duration_s, is_switched)


def start_results(plan: Plan, parent: Path) -> Path:
    """
    Make the results folder of a run in `parent`, with its scenario and provenance, and return it.

    Raises
    ------
    ResultsError
        If the folder cannot be made.
    WriteError
        If the files in it cannot be written, as on a full disk; the folder is removed again.

    """
    from auv_experiment.scenario.loading import scenario_to_yaml

    text = scenario_to_yaml(plan.scenario)
    record = results.provenance(
        plan.scenario, mode=plan.mode, overrides=plan.overrides, duration_s=plan.duration_s
    )
    if plan.mode in ROS_MODES:
        record["layout"] = plan.layout
    folder = results.make_results_dir(parent, plan.name)
    try:
        (folder / results.LOGS).mkdir()
        write_text(folder / results.SCENARIO_FILE, text)
        results.write_beginning(folder, record, has_ending=plan.mode in ROS_MODES)
    except OSError:
        shutil.rmtree(folder, ignore_errors=True)  # leave nothing of a run that did not start
        raise
    return folder
