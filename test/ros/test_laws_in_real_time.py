"""Claim: the laws that give a wrench fly in real time too."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from auv_bringup.bag_reader import read_recording
from auv_bringup.scenario import load_scenario

pytestmark = pytest.mark.ros


@pytest.mark.parametrize("name", ["ch4_region_limited", pytest.param("ch3_circle", marks=pytest.mark.slow)])
def test_a_law_flies_in_real_time_and_brings_its_vehicles_nearer(name, tmp_path):
    command = [sys.executable, "-m", "auv_bringup.cli", name, "--mode", "realtime", "--duration", "4"]
    command += ["--no-figures", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=os.environ, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (folder,) = tmp_path.iterdir()
    scenario = load_scenario(str(folder / "scenario.yaml"))
    assert scenario.sampling == "sampled"
    recorded = read_recording(folder / "bag", scenario)
    assert recorded.t_s[-1] > 3.0
    for index in range(recorded.n_vehicles):
        path = scenario.reference_of(index)
        goal = scenario.agent.controller.params.centre_ned_m if path is None else path.at(4.0).position
        before_m, after_m = np.linalg.norm(recorded.position_ned_m[[0, -1], index] - goal, axis=-1)
        assert after_m < 0.95 * before_m
    metrics = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["safe_command_ratio"] == 0.0
