"""
Other programs with the same work, each in its own Python environment.

    python -m benchmarks --peers        makes .venv-peers from requirements/peers.lock first

Run as a program, with the peers' Python, this file is the peer: it answers every line on its standard input
with its vehicle-steps per second of processor time.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
VENV = ROOT / ".venv-peers"
PEERS = ("auv_sim_bench", "vmas", "vmas_1000")
RUNS = {"vmas_1000": 1000}
"""Number of runs that a peer advances at once, if more than one."""
_INSTALL_S = 600.0


def peers_python() -> Path:
    """Return the Python of the peers; install it if it is missing."""
    python = VENV / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(VENV)], check=True, timeout=_INSTALL_S)
        lock = ROOT / "requirements" / "peers.lock"
        pip = [
            str(python),
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-deps",
            "--require-hashes",
            "-r",
            str(lock),
        ]
        subprocess.run(pip, check=True, timeout=_INSTALL_S)
    return python


class Peer:
    """A peer that flies this number of vehicles; `absent` says why it is missing, empty otherwise."""

    def __init__(self, name: str, count: int, python: Path | None) -> None:
        self._process: subprocess.Popen[str] | None = None
        self.absent = "not asked for (--peers)"
        if python is None:
            return
        self._process = subprocess.Popen(
            [str(python), __file__, name, str(count)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        is_ready = self._line() == "ready"
        self.absent = "" if is_ready else "not in .venv-peers"

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()

    def rate(self, block_s: float) -> float:
        """Return its vehicle-steps per second of processor time, over a block of this length."""
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(f"{block_s}\n")
        self._process.stdin.flush()
        return float(self._line())

    def _line(self) -> str:
        assert self._process is not None
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()


def _auv_sim_bench(count: int) -> Any:
    """Return one forward Euler step of the dynamics of this number of vehicles."""
    import numpy as np
    from auv_sim_bench.dynamics import AUVDynamics

    vehicles = [AUVDynamics() for _ in range(count)]
    force, torque = np.array([5.0, 0.0, 0.0]), np.array([0.0, 0.1, 0.05])

    def step() -> None:
        for vehicle in vehicles:
            vehicle.step(0.005, force, torque)

    return step


def _vmas(count: int, runs: int) -> Any:
    """Return one step of this number of flocking runs: points in the plane, five substeps of Euler."""
    import torch
    from vmas import make_env

    torch.set_num_threads(1)
    env = make_env(scenario="flocking", num_envs=runs, n_agents=count, device="cpu", seed=1)
    env.reset()
    actions = [torch.zeros(runs, 2) for _ in range(count)]
    return lambda: env.step(actions)


def _answer(name: str, count: int) -> None:
    runs = RUNS.get(name, 1)
    step = _auv_sim_bench(count) if name == "auv_sim_bench" else _vmas(count, runs)
    step()
    print("ready", flush=True)
    for line in sys.stdin:
        steps, began_s = 0, time.process_time()
        while time.process_time() - began_s < float(line):
            step()
            steps += 1
        print(count * runs * steps / (time.process_time() - began_s), flush=True)


if __name__ == "__main__":
    _answer(sys.argv[1], int(sys.argv[2]))
