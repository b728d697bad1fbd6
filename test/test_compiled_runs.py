"""A run with everything compiled is the run of the plain source, which is what nodes fly."""

import os
import subprocess
import sys

import numpy as np

from auv_experiment.recording import Recording

# Between them these use every function that is compiled: both filters, sonar, bursts, levels, every model.
RUNS = {
    "flock_acoustic": ("dt_s=0.02",),
    "flock_drift": ("acoustics.preset=micromodem_fdp",),
    "ch6_obstacles": ("sampling=sampled",),
    "medium_access": (),
    "torpedo_fleet": (),
}

_PROGRAM = """
import sys
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario
folder, pairs = sys.argv[1], sys.argv[2:]
for pair in pairs:
    name, *overrides = pair.split()
    run_in_process(load_scenario(name, overrides=overrides, duration_s=6.0)).save(f"{folder}/{name}.npz")
"""


def _flown(folder, switch):
    folder.mkdir()
    arguments = [" ".join((name, *overrides)) for name, overrides in RUNS.items()]
    subprocess.run(
        [sys.executable, "-c", _PROGRAM, str(folder), *arguments],
        env={**os.environ, "NUMBA_DISABLE_JIT": switch, "PYTHONPATH": os.pathsep.join(sys.path)},
        timeout=240,
        check=True,
    )
    return {name: Recording.load(folder / f"{name}.npz") for name in RUNS}


def test_compiled_and_plain_runs_are_equal(tmp_path):
    compiled, plain = _flown(tmp_path / "compiled", "0"), _flown(tmp_path / "plain", "1")
    for name, run in plain.items():
        assert len(run.events) > 0 or name.startswith("ch6")
        for key, value in vars(run).items():
            if isinstance(value, np.ndarray):
                other = getattr(compiled[name], key)
                np.testing.assert_allclose(other, value, rtol=1e-9, atol=1e-9, err_msg=f"{name}: {key}")
