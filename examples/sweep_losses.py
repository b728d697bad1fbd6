"""Fly the main job at several loss rates, with two seeds each, and print a table."""

import shoal

LOSS = "acoustics.outage.params.loss_prob"


def main() -> None:
    """Sweep and print."""
    table = shoal.sweep("flock_acoustic", grid={LOSS: [0.0, 0.4, 0.8]}, seeds=range(2), duration_s=20.0)
    columns = ["neighbour_age_mean_s", "packet_delivery_ratio"]
    print(table.groupby(f"scenario.{LOSS}")[columns].mean().round(2))


if __name__ == "__main__":
    main()
