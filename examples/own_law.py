"""Compare the separation law of `plugins/separation/steep.py` with the built-in one."""

import os
from pathlib import Path

import shoal

PLUGINS = Path(__file__).parent / "plugins"


def main() -> None:
    """Fly both and print."""
    os.environ["SHOAL_PLUGINS"] = str(PLUGINS)
    for law in ("mathematical", "steep"):
        scenario = shoal.load("flock_acoustic")
        scenario["agent.separation"] = {"kind": law}
        metrics = shoal.run(scenario, seed=3, duration_s=40.0).metrics
        print(f"{law}: smallest distance {metrics['pair_distance_min_m']:.2f} m")


if __name__ == "__main__":
    main()
