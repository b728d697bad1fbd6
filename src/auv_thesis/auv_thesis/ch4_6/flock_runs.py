"""The runs of chapters 5 and 6, defined once for figures, tables and claims."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from auv_flocking.flocking.potential import Params as FlockingParams
from auv_flocking.separation import fuzzy
from auv_thesis.ch4_6.stiffness import (
    attraction_ps,
    equilibrium_m,
    gain_for_stiffness,
    resting_stiffness_ps,
)
from auv_thesis.items import RunSpec

COARSE = ("dt_s=0.02", "period_s=0.1")
"""Gives the same numbers to four digits as steps of 0.01 s; recorded ten times per second."""

FOUR_LEADERS = RunSpec("ch5_four_leaders", COARSE)
ONE_LEADER = RunSpec("ch5_one_leader", COARSE)
BLIND = RunSpec("ch5_one_leader_blind", COARSE)
OBSTACLES = RunSpec("ch5_obstacles", COARSE)
ON_A_MODEM = RunSpec("ch5_communication")
ON_A_MODEM_OBSTACLES = RunSpec("ch5_communication_obstacles")

FUZZY_FOUR_LEADERS = RunSpec("ch6_four_leaders", COARSE)
FUZZY_ONE_LEADER = RunSpec("ch6_one_leader", COARSE)
FUZZY_OBSTACLES = RunSpec("ch6_obstacles", COARSE)
FUZZY_PRINTED_OBSTACLES = RunSpec(
    "ch6_obstacles", (*COARSE, "agent.separation.params.obstacles=printed"), 200.0
)

N_VEHICLES = 4
SPACING_M = FlockingParams().spacing_m
ATTRACTION_PS = attraction_ps(FlockingParams(), N_VEHICLES, followers_know_path=True)
_FUZZY = fuzzy.Separation(fuzzy.Params())
FUZZY_STIFFNESS_PS = resting_stiffness_ps(_FUZZY, ATTRACTION_PS, N_VEHICLES, SPACING_M)
FUZZY_RESTS_AT_M = equilibrium_m(_FUZZY, ATTRACTION_PS, N_VEHICLES, SPACING_M)
EQUAL_GAIN = gain_for_stiffness(FUZZY_STIFFNESS_PS, ATTRACTION_PS, N_VEHICLES, SPACING_M)
"""With this gain the mathematical law is as stiff as the fuzzy law where their flocks rest."""
_EQUAL = f"agent.separation.params.gain={EQUAL_GAIN:.6g}"
EQUAL_FOUR_LEADERS = RunSpec("ch5_four_leaders", (*COARSE, _EQUAL))
EQUAL_ONE_LEADER = RunSpec("ch5_one_leader", (*COARSE, _EQUAL))

STARTS = 20
STARTS_SEED = 5
DRAWN_S = 40.0
_FARTHEST_M = (18.0, 20.0)
_NEAREST_M = 3.0


def drawn_starts(seed: int, count: int) -> list[tuple[str, ...]]:
    """
    Return overrides for `count` flocks whose farthest pair starts 18 to 20 m apart, as Fig. 5.6a shows.

    The box is that of Fig. 5.5, the nearest pair starts at least 3 m apart.
    """
    rng = np.random.default_rng(seed)
    groups: list[tuple[str, ...]] = []
    while len(groups) < count:
        starts = rng.uniform((-15.0, -15.0, 0.0), (15.0, 15.0, 12.0), (N_VEHICLES, 3)).round(3)
        distances_m = [float(np.linalg.norm(a - b)) for a, b in combinations(starts, 2)]
        if min(distances_m) >= _NEAREST_M and _FARTHEST_M[0] <= max(distances_m) <= _FARTHEST_M[1]:
            groups.append(
                tuple(f"vehicles.{i}.position_ned_m={start.tolist()}" for i, start in enumerate(starts))
            )
    return groups


_GROUPS = drawn_starts(STARTS_SEED, STARTS)
DRAWN = {
    spec: tuple(
        RunSpec(spec.scenario, (*spec.overrides, *group), DRAWN_S, keep_recording=False) for group in _GROUPS
    )
    for spec in (
        FOUR_LEADERS,
        ONE_LEADER,
        FUZZY_FOUR_LEADERS,
        FUZZY_ONE_LEADER,
        EQUAL_FOUR_LEADERS,
        EQUAL_ONE_LEADER,
    )
}
"""The same flocks from drawn starts."""

_AT_REST = "reference.params.rate_radps=0.0"
RESTING = RunSpec("ch5_four_leaders", (*COARSE, _AT_REST), 60.0)
RESTING_BLIND = RunSpec("ch5_one_leader_blind", (*COARSE, _AT_REST), 60.0)

CHANNEL_S = 200.0
SLOTS_S = (0.1, 0.5, 2.0)
LOSSES = (0.0, 0.3, 0.6)
MATCHED = (
    "agent.flocking.params.bandwidth_ratio=0.05",
    "agent.consensus.params.rate_ps=0.05",
    "agent.neighbours.timeout_s=300.0",
)
"""Feedback and consensus twenty times slower, and neighbour estimates kept through minutes of silence."""


def on_channel(slot_s: float, loss: float, changes: tuple[str, ...] = ()) -> RunSpec:
    """Return the flock without obstacles on a TDMA channel with this slot length and loss."""
    return RunSpec(
        "ch5_communication",
        (
            "environment.obstacles=[]",
            f"acoustics.mac.params.slot_s={slot_s:g}",
            f"acoustics.outage.params.loss_prob={loss:g}",
            "agent.hold_s=60.0",
            *changes,
        ),
        CHANNEL_S,
    )


AS_PRINTED_ON = {(slot_s, loss): on_channel(slot_s, loss) for slot_s in SLOTS_S for loss in LOSSES}
MATCHED_ON = {(slot_s, loss): on_channel(slot_s, loss, MATCHED) for slot_s in SLOTS_S[1:] for loss in LOSSES}
