"""Claim: a controller, a separation law, a vehicle, a metric and a figure are one new file each."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import auv_flocking.separation
from auv_core.params import ConfigError
from auv_experiment.scenario.loading import load_scenario

PLUGINS = Path(__file__).parent / "plugins"
PACKAGES = [
    str(path) for path in (Path(__file__).parents[1] / "src").glob("auv_*") if path.name != "auv_msgs"
]


_PARAMS = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Params:
    \"\"\"Nothing to choose.\"\"\"
"""
_NO_VELOCITY = """
class Separation:
    def __init__(self, params): ...
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    plugins = shutil.copytree(PLUGINS, tmp_path_factory.mktemp("user") / "plugins")
    places = os.pathsep.join([*PACKAGES, os.environ.get("PYTHONPATH", "")])
    return {**os.environ, "PYTHONPATH": places, "SHOAL_PLUGINS": str(plugins)}


def fly(environment, out_dir, *arguments):
    command = [
        sys.executable,
        "-m",
        "auv_bringup.tools.run",
        *arguments,
        "--mode",
        "inprocess",
    ]
    command += ["--out", str(out_dir)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (metrics,) = out_dir.glob("*/metrics.json")
    return json.loads(metrics.read_text(encoding="utf-8"))


def test_a_new_controller_and_a_new_vehicle_fly_by_name(environment, tmp_path):
    metrics = fly(environment, tmp_path, str(PLUGINS / "kayak_on_a_spring.yaml"), "--format", "pdf")
    assert metrics["position_err_max_m"] < 0.3
    assert metrics["lyapunov_energy_first_rise_s"] > 1.0
    assert {path.suffix for path in tmp_path.glob("*/figures/depths.*")} == {".pdf", ".png"}


def test_a_new_vehicle_that_cannot_stop_flies_a_course_with_all_figures(environment, tmp_path):
    metrics = fly(environment, tmp_path, str(PLUGINS / "dart_on_a_racetrack.yaml"))
    assert metrics["depth_overshoot_m"] < 0.5
    assert metrics["fin_effort_rad2s"] > 0.0
    assert metrics["propeller_turns"] == pytest.approx(30.0 * 15.3, rel=0.1)
    assert {path.stem for path in tmp_path.glob("*/figures/*.png")} >= {"course_plan", "actuators"}


def test_a_new_separation_law_and_a_new_vehicle_fly_the_main_job(environment, tmp_path):
    overrides = ["--set", "agent.separation={kind: steady_push, params: {strength_mps: 0.4}}"]
    for index in range(4):
        overrides += ["--set", f"vehicles.{index}.model.preset=kayak"]
    metrics = fly(environment, tmp_path, "flock_acoustic", "--no-figures", "--duration", "60", *overrides)
    assert metrics["pair_distance_min_m"] > 0.4
    assert metrics["formed_at_s"] < 60.0
    assert metrics["depth_spread_m"] > 0.1


def test_without_the_folder_the_names_are_refused(environment, tmp_path):
    environment = {**environment, "SHOAL_PLUGINS": ""}
    with pytest.raises(
        AssertionError, match=r"agent\.separation\.kind: 'steady_push' is not allowed; allowed: "
    ):
        fly(environment, tmp_path, "flock_acoustic", "--set", "agent.separation={kind: steady_push}")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", r"scenario\.agent\.separation\.kind: auv_flocking\.separation\.half has no Params; allowed: "),
        (_PARAMS, r"auv_flocking\.separation\.half: no Separation; allowed: a file that defines the class"),
        (_PARAMS + _NO_VELOCITY, r"auv_flocking\.separation\.half: Separation has no velocity; allowed: "),
    ],
)
def test_a_file_that_is_half_written_is_refused_in_one_line(text, complaint, monkeypatch, tmp_path):
    (tmp_path / "separation").mkdir()
    (tmp_path / "separation" / "half.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(auv_flocking.separation, "__path__", [*auv_flocking.separation.__path__])
    monkeypatch.delitem(sys.modules, "auv_flocking.separation.half", raising=False)
    monkeypatch.setenv("SHOAL_PLUGINS", str(tmp_path))
    with pytest.raises(ConfigError, match=f"^{complaint}[^\n]*$"):
        load_scenario("flock_acoustic", overrides=["agent.separation={kind: half}"])
    sys.modules.pop("auv_flocking.separation.half", None)
