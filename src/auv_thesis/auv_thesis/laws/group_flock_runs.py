"""
Runs of the laws of thesis Section 7.3 in a flock: controllers under one flocking law, and separation past an
obstacle.

Flock, modem, disturbances and draws are those of `separation_runs`. The controllers have the mathematical
separation and are equally stiff: 300 N per m/s. The obstacle lies 0.57 m outside the path, which passes it
after 80 s; its safety distance is 2 m. The flock starts 15 m away from it.
"""

from __future__ import annotations

from dataclasses import replace

from auv_thesis.items import RunSpec
from auv_thesis.laws.separation_runs import CONDITIONS, LAWS, NOISE, SEEDS, spec_of

MATHEMATICAL, AT_REST, LEARNING = "mathematical", "adaptive fuzzy", "adaptive fuzzy with obstacles"
PI, SLIDING, H_INFINITY = "PI (velocity_pi)", "sliding mode", "H-infinity"
CONTROLLERS: dict[str, tuple[str, ...]] = {
    PI: (),
    SLIDING: ("agent.controller={kind: velocity_sliding_mode}",),
    H_INFINITY: ("agent.controller={preset: velocity_h_infinity_odin}",),
}
ROBUST = (SLIDING, H_INFINITY)
RUNS = {
    (controller, condition): spec_of((*LAWS[MATHEMATICAL], *words), changes)
    for condition, changes in CONDITIONS.items()
    if condition not in (NOISE, "forces up to 200 N")
    for controller, words in CONTROLLERS.items()
}
DRAWN = {
    (controller, NOISE): tuple(
        spec_of((*LAWS[MATHEMATICAL], *words), CONDITIONS[NOISE], seed) for seed in SEEDS
    )
    for controller, words in CONTROLLERS.items()
}

SAFETY_M = 2.0
PAST_OBSTACLE_S = 120.0
_OBSTACLE = (
    f"environment.obstacles=[{{position_ned_m: [6.76, 6.57, 10.0], safety_distance_m: {SAFETY_M}}}]",
    "random_starts.centre_ned_m=[-8.0, 12.0, 10.0]",
)
SEPARATIONS: dict[str, tuple[str, ...]] = {
    MATHEMATICAL: LAWS[MATHEMATICAL],
    AT_REST: LAWS[AT_REST],
    LEARNING: ("agent.separation.kind=adaptive_fuzzy_obstacles",),
}


def _past_obstacle(law: str, condition: str, seed: int) -> RunSpec:
    spec = spec_of(SEPARATIONS[law], CONDITIONS[condition], seed)
    return replace(spec, overrides=(*spec.overrides, *_OBSTACLE), duration_s=PAST_OBSTACLE_S)


PAST = {
    (law, condition): tuple(_past_obstacle(law, condition, seed) for seed in SEEDS)
    for law, condition in (
        (MATHEMATICAL, NOISE),
        (AT_REST, NOISE),
        (LEARNING, NOISE),
    )
}
