"""A flock as a learning environment with the methods of Gymnasium, which need not be installed."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import shoal

MOST = np.array([60.0, 60.0, 60.0, 0.0, 0.0, 10.0])
"""Force (N) and moment (N m) of an action of ones, along the axes of the body."""
TOUCH_M = 0.6

Observation = NDArray[np.float64]


class FlockEnvironment:
    """
    Actions in [-1, 1] steer one vehicle, its own laws steer each other one; the reward favours staying near.
    """

    def __init__(self, vehicle_id: str, duration_s: float) -> None:
        self._id = vehicle_id
        self._simulation = shoal.Simulation("flock_acoustic", duration_s=duration_s)

    def reset(self, *, seed: int | None = None) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, by default with the next seed; return the observation."""
        self._simulation.reset(self._simulation.scenario.seed + 1 if seed is None else seed)
        return self._observation(), {}

    def step(
        self, action: NDArray[np.floating[Any]]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Fly one control period; return observation, reward, whether hulls touch, whether time is up."""
        self._simulation.step({self._id: MOST * np.clip(action, -1.0, 1.0)})
        distances_m = self._distances_m()
        has_touched = min(distances_m) < TOUCH_M
        reward = -float(np.mean(distances_m))
        return self._observation(), reward, has_touched, self._simulation.is_done, {}

    def _observation(self) -> Observation:
        """Return the vehicle's own estimate: position (m), attitude, velocities (m/s, rad/s)."""
        estimate = self._simulation.estimates[self._id]
        return np.array([*estimate.position, *estimate.attitude, *estimate.nu])

    def _distances_m(self) -> list[float]:
        states = dict(self._simulation.states)
        own = states.pop(self._id)
        return [math.dist(own.position, other.position) for other in states.values()]


def main() -> None:
    """Play an episode with random actions, and print its total reward."""
    environment = FlockEnvironment("auv_2", duration_s=10.0)
    random = np.random.default_rng(1)
    observation, _ = environment.reset(seed=3)
    total, is_over = 0.0, False
    while not is_over:
        action = random.uniform(-1.0, 1.0, 6).astype(np.float32)
        observation, reward, has_touched, is_late, _ = environment.step(action)
        total += reward
        is_over = has_touched or is_late
    print(f"{len(observation)} numbers observed; total reward with random actions: {total:.0f}")


if __name__ == "__main__":
    main()
