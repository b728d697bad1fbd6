"""Claim: the laws that give a wrench fly in real time too, close to the run in one process."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from auv_bringup.bag_reader import read_recording
from auv_bringup.experiment import run_in_process
from auv_bringup.scenario import load_scenario

pytestmark = pytest.mark.ros

NEAR_M = 0.5
"""A command may come a tick late, and the vehicles are under way at up to 2.5 m/s."""


@pytest.mark.parametrize(
    "name", ["ch2_pfapd_obstacles_corrected", "ch3_circle_corrected", "ch4_region_limited"]
)
def test_a_law_flies_in_real_time_as_it_does_in_one_process(name, tmp_path):
    command = [sys.executable, "-m", "auv_bringup.cli", name, "--mode", "realtime", "--duration", "4"]
    command += ["--no-figures", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=os.environ, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (folder,) = tmp_path.iterdir()
    scenario = load_scenario(str(folder / "scenario.yaml"))
    assert scenario.sampling == "sampled"
    recorded, expected = read_recording(folder / "bag", scenario), run_in_process(scenario)
    ticks = min(recorded.n_ticks, expected.n_ticks)
    apart_m = np.linalg.norm(recorded.position_ned_m[:ticks] - expected.position_ned_m[:ticks], axis=-1)
    assert ticks * scenario.period_s > 3.0
    assert apart_m.max() < NEAR_M
    metrics = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["safe_command_ratio"] == 0.0
