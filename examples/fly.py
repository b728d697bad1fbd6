"""Fly the main job for a minute, and print how near the vehicles came to each other."""

import shoal


def main() -> None:
    """Fly and print."""
    scenario = shoal.load("flock_acoustic")
    scenario["acoustics.outage.params.loss_prob"] = 0.5
    result = shoal.run(scenario, seed=3, duration_s=60.0)
    print(f"smallest distance: {result.metrics['pair_distance_min_m']:.2f} m")
    print(f"packets delivered: {result.metrics['packet_delivery_ratio']:.0%}")


if __name__ == "__main__":
    main()
