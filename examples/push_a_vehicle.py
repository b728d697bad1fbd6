"""Step a flight, and push one vehicle upwards for ten seconds while the others fly on."""

import shoal

UP = (0.0, 0.0, -60.0, 0.0, 0.0, 0.0)
"""Force (N) along the axes of the body, then moment (N m)."""


def main() -> None:
    """Fly and print."""
    scenario = shoal.load("flock_acoustic")
    scenario["duration_s"] = 30.0
    simulation = shoal.Simulation(scenario, seed=3)
    start_m = simulation.states["auv_2"].position[2]
    while not simulation.is_done:
        is_pushed = 10.0 <= simulation.time_s < 20.0
        simulation.step({"auv_2": UP} if is_pushed else None)
    end_m = simulation.states["auv_2"].position[2]
    print(f"auv_2: {start_m:.1f} m deep at the start, {end_m:.1f} m at the end")
    print(f"smallest distance: {simulation.result().metrics['pair_distance_min_m']:.2f} m")


if __name__ == "__main__":
    main()
