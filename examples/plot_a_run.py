"""Open a saved run, a results folder or a bag, and draw the depth of every vehicle."""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import shoal


def draw_depths(run: Path, file: Path) -> None:
    """Write a figure of the depths (m) of a run."""
    position = shoal.open(run).to_xarray()["position_ned_m"]
    figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
    for name in position["vehicle"].values:
        depth = position.sel(vehicle=name, axis="down")
        axes.plot(depth["time"], depth, label=name)
    axes.set(xlabel="time (s)", ylabel="depth (m)")
    axes.invert_yaxis()
    axes.legend()
    figure.savefig(file)
    plt.close(figure)


def main() -> None:
    """Draw the run in the command line, or else fly one."""
    file = Path("depths.png")
    if len(sys.argv) > 1:
        draw_depths(Path(sys.argv[1]), file)
    else:
        with tempfile.TemporaryDirectory() as folder:
            run = shoal.run("flock_acoustic", duration_s=20.0).save(folder, with_figures=False)
            draw_depths(run, file)
    print(f"written: {file}")


if __name__ == "__main__":
    main()
