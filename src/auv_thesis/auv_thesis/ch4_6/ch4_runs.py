"""The runs of chapter 4: our default case, ablations, and random starts."""

from __future__ import annotations

from typing import Any

import numpy as np

from auv_thesis.items import RunSpec

BOX_M = ((5.0, 20.0), (0.0, 20.0), (0.0, 20.0))
"""Limits of x, y and z in the thesis's Figs 4.5 and 4.6."""
STARTS = 30
"""Random starts per set of layer gains, for collisions."""
LONG_STARTS, LIMITED_STARTS = 10, 20
"""The first of them, flown until they arrive: with our gains, and with at most 200 N."""
STARTS_SEED = 0
APPROACH_S = 12.0
"""Vehicles from the corners meet within this time (s) or never, unless their force is limited."""
ARRIVED_S = 60.0
"""Vehicles that arrive have done so by then (s)."""
_COARSE = ("dt_s=0.02", "period_s=0.02")
_PRINTED = "agent.controller.params.layer_gains_pm3=[0.1,0.1]"
_NO_G = "agent.controller.params.gravity_compensation=false"


def _from(starts: Any) -> tuple[str, ...]:
    return tuple(f"vehicles.{i}.position_ned_m={list(start)}" for i, start in enumerate(starts))


def corner_starts(seed: int, count: int) -> list[tuple[str, ...]]:
    """Return overrides for `count` groups that start within 2 m of three corners of the thesis's plot box."""
    rng = np.random.default_rng(seed)
    groups = []
    for _ in range(count):
        group = []
        for corner in rng.permutation(8)[:3]:
            ends = [limits[corner >> bit & 1] for bit, limits in enumerate(BOX_M)]
            inward = [-1.0 if end > 10.0 else 1.0 for end in ends]
            jitter_m = rng.uniform(0.0, 2.0, 3)
            group.append(
                [round(e + s * j, 3) for e, s, j in zip(ends, inward, jitter_m.tolist(), strict=True)]
            )
        groups.append(_from(group))
    return groups


DEFAULT = RunSpec("ch4_region")
LIMITED = RunSpec("ch4_region_limited", _COARSE)
PRINTED = RunSpec("ch4_region", (*_COARSE, _PRINTED))
OTHER_CASE = RunSpec(
    "ch4_region", (*_COARSE, _PRINTED, *_from([(20.0, 20.0, 20.0), (5.0, 0.0, 0.0), (20.0, 0.0, 5.0)]))
)
NO_COMPENSATION = RunSpec("ch4_region", (*_COARSE, _PRINTED, _NO_G))
_GROUPS = corner_starts(STARTS_SEED, STARTS)
RANDOM = tuple(RunSpec("ch4_region", (*_COARSE, *group), APPROACH_S) for group in _GROUPS)
RANDOM_PRINTED = tuple(RunSpec("ch4_region", (*_COARSE, _PRINTED, *group), APPROACH_S) for group in _GROUPS)
RANDOM_LONG, RANDOM_LIMITED = (
    tuple(RunSpec(scenario, (*_COARSE, *group), ARRIVED_S, keep_recording=False) for group in _GROUPS[:count])
    for scenario, count in (("ch4_region", LONG_STARTS), ("ch4_region_limited", LIMITED_STARTS))
)
