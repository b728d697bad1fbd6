"""What thrusters can give, intact and after a loss, and how far three allocators miss what they cannot."""

import numpy as np
from numpy.typing import NDArray

from auv_control.allocation import make_allocator
from auv_core.compiled import use_compiler
from auv_core.models import thrusters_of
from auv_core.params import load_section
from auv_core.plugins import list_plugins
from auv_core.thrusters import Thrusters, axis_maxima
from auv_experiment.scenario.loading import load_scenario

VEHICLES = {
    "odin": "{preset: odin, params: {actuators: thrusters}}",
    "bluerov2_heavy": "{preset: bluerov2_heavy}",
}
FOLDER = "auv_control.allocation"
SPREAD = 0.27
"""Standard deviation of each component of a wrench, as a part of its largest value alone."""

Floats = NDArray[np.float64]


def thrusters_on(model: str) -> Thrusters:
    """Return the thrusters of a model, as a scenario names it."""
    scenario = load_scenario(
        "hover_thrusters", overrides=[f"vehicles.0.model={model}", "vehicles.1.fault={}"]
    )
    return thrusters_of(scenario.vehicles[0].model)


def largest(thrusters: Thrusters, *lost: int) -> Floats:
    """Return the largest pure forces (N) and moments (N m) in both senses of each axis."""
    limits = thrusters.lowest_n, thrusters.highest_n
    return axis_maxima(thrusters.matrix(lost), *limits).min(axis=1)


def print_misses(name: str, thrusters: Thrusters) -> None:
    """Print the relative errors of the allocators over the wrenches that saturate least-norm forces."""
    T = thrusters.matrix()
    weights = np.array([1.0] * 3 + [1.0 / thrusters.moment_arm_m] * 3)
    wrenches = SPREAD * largest(thrusters) * np.random.default_rng(15).standard_normal((1000, 6))
    least_norm = wrenches @ np.linalg.pinv(T).T
    is_out = ((least_norm < thrusters.lowest_n) | (least_norm > thrusters.highest_n)).any(axis=1)
    print(f"{name}: 1000 wrenches, of which {is_out.sum()} saturate")
    for kind in list_plugins(FOLDER):
        allocator = make_allocator(load_section({"kind": kind}, kind, FOLDER), thrusters)
        taus = [tuple(tau) for tau in wrenches.tolist()]
        forces = np.array([allocator.forces_n(tau) for tau in taus])
        given, asked = weights * (forces @ T.T), weights * wrenches
        errors = np.linalg.norm(given - asked, axis=1) / np.linalg.norm(asked, axis=1)
        cosines = (given * asked).sum(axis=1) / np.linalg.norm(given, axis=1) / np.linalg.norm(asked, axis=1)
        turns_deg = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
        print(
            f"  {kind:<10}  error mean {errors[is_out].mean():.3f}, worst {errors[is_out].max():.2f}; "
            f"direction {turns_deg[is_out].mean():.1f} deg"
        )


def main() -> None:
    """Print both tables for both vehicles."""
    use_compiler()
    for name, model in VEHICLES.items():
        thrusters = thrusters_on(model)
        for lost in ((), (1,), (5,)):
            pairs = zip("XYZKMN", largest(thrusters, *lost), strict=True)
            axes = ", ".join(f"{axis} {most:.1f}" for axis, most in pairs)
            print(f"{name}, {f'thruster {lost[0]} lost' if lost else 'intact'}: {axes}")
        print_misses(name, thrusters)


if __name__ == "__main__":
    main()
