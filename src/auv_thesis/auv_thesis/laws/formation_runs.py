"""
Runs that compare laws for a group in formation: three vehicles of Table 3.1 on the circles of thesis Section
3.5.1, 10 m apart, sampled at 10 Hz. They start within 1 m of their paths, so that 40 N suffice.

All laws have the model of Table 3.1 and one stiffness, K_D lambda = 100 N/m in surge. "Fixed model" is the
corrected law of chapter 3 without adaptation: the sliding-mode law within its layer. Each of the new laws
flies with and without springs between neighbours. Noise is drawn ten times; so are the losses of the modem,
which only the springs feel.
"""

from __future__ import annotations

from auv_thesis.items import RunSpec

DURATION_S = 80.0
JUDGED_AFTER_S = 30.0
SPACING_M = 10.0
SEEDS = tuple(range(721, 731))
"""Each draws other noise and losses; none was used to choose a parameter."""

_SAMPLED = ("sampling=sampled", "dt_s=0.1", "period_s=0.1")
_NEAR_THE_PATHS = tuple(
    f"vehicles.{index}.position_ned_m={place}"
    for index, place in enumerate(([0.5, 10.5, 9.5], [-0.5, 19.5, 10.0], [0.5, 30.0, 10.5]))
)
_BLEND = "blend_s: 10.0"
_STILL = (
    "inertia_adaptation: [0, 0, 0, 0], linear_adaptation: [0, 0, 0, 0], quadratic_adaptation: [0, 0, 0, 0]"
)
_ALONE = "coupling_weight: 0.0"
_N_VEHICLES = 3

FIXED, ADAPTIVE = "fixed model", "adaptive (chapter 3, corrected)"
SLIDING, SLIDING_SPRINGS = "sliding mode", "sliding mode and springs"
H_INFINITY, H_INFINITY_SPRINGS = "H-infinity", "H-infinity and springs"
LAWS = {
    FIXED: f"{{preset: adaptive_corrected, params: {{{_BLEND}, {_STILL}}}}}",
    ADAPTIVE: f"{{preset: adaptive_corrected, params: {{{_BLEND}}}}}",
    SLIDING: f"{{kind: formation_sliding_mode, params: {{{_BLEND}, {_ALONE}}}}}",
    SLIDING_SPRINGS: f"{{kind: formation_sliding_mode, params: {{{_BLEND}}}}}",
    H_INFINITY: f"{{preset: formation_h_infinity_table_3_1, params: {{{_BLEND}, {_ALONE}}}}}",
    H_INFINITY_SPRINGS: f"{{preset: formation_h_infinity_table_3_1, params: {{{_BLEND}}}}}",
}
ROBUST = (SLIDING, H_INFINITY)
WITH_SPRINGS = {SLIDING: SLIDING_SPRINGS, H_INFINITY: H_INFINITY_SPRINGS}

_TABLE_3_1 = {
    "inertia": (99.0, 108.5, 126.5, 29.1),
    "linear_damping": (10.0, 0.0, 10.0, 1.603),
    "quadratic_damping": (227.18, 405.42, 227.18, 12.937),
}


def _plants(factors: tuple[float, float, float]) -> tuple[str, ...]:
    """Return the vehicles with inertia and drag scaled by a factor each; the laws' models stay the same."""
    return tuple(
        f"vehicles.{index}.model.params.{name}={[round(factor * value, 6) for value in values]}"
        for index, factor in enumerate(factors)
        for name, values in _TABLE_3_1.items()
    )


NOMINAL, NOISE, LIMITS = "nominal", "noise 5 cm, 1 cm/s", "limits 40 N"
DISTURBANCES: dict[str, tuple[str, ...]] = {
    "plant +30 %": _plants((1.3, 1.3, 1.3)),
    "plant -30 %": _plants((0.7, 0.7, 0.7)),
    "hulls +30 %, 0, -30 %": _plants((1.3, 1.0, 0.7)),
    "current 0.1 m/s": ("environment.current_ned_mps=[0.1, 0.0, 0.0]",),
}
CONDITIONS: dict[str, tuple[str, ...]] = {
    NOMINAL: (),
    **DISTURBANCES,
    LIMITS: tuple(f"vehicles.{index}.model.params.max_force_n=40.0" for index in range(_N_VEHICLES)),
}
_NOISY = "environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.01}}"


def _spec(law: str, *changes: str) -> RunSpec:
    words = (*_SAMPLED, *_NEAR_THE_PATHS, f"agent.controller={LAWS[law]}", *changes)
    return RunSpec("ch3_circle_corrected", words, DURATION_S)


RUNS = {(law, condition): _spec(law, *changes) for condition, changes in CONDITIONS.items() for law in LAWS}
NOISY_LAWS = (SLIDING, SLIDING_SPRINGS, H_INFINITY, H_INFINITY_SPRINGS)
"""Without springs sliding mode is the fixed model in its layer, which the noise does not leave."""
NOISY = {(law, seed): _spec(law, _NOISY, f"seed={seed}") for law in NOISY_LAWS for seed in SEEDS}
