"""
Runs that compare separation laws in one flock: the laws, their stiffness, and the disturbances.

The flocking law is `potential` with gains that suit the modem, so that only the separation law keeps
distances: the main job's own law would widen them with its uncertainty and bound the approach. There are no
obstacles, so that the distance error is the law's own.

Parameters: the mathematical law as in the main job; the fuzzy law with a set "zero" of 0.25 m, since the
0.045 m that give the thesis's distances are too stiff for a hull of 125 kg and one report per second; the
adaptive law with its defaults. These laws differ in stiffness. The mathematical law therefore flies once more
for each of them, with the gain that gives it the same stiffness. The adaptive law also has an integral, which
removes any constant offset: the mathematical law flies with a spacing that removes it, too.
"""

from __future__ import annotations

from scipy.optimize import brentq

from auv_flocking.flocking.potential import Params as FlockingParams
from auv_flocking.separation import adaptive_fuzzy, fuzzy
from auv_thesis.ch4_6.stiffness import (
    attraction_ps,
    gain_for_distance,
    gain_for_stiffness,
    mathematical_law,
    resting_stiffness_ps,
    stiffness_ps,
)
from auv_thesis.items import RunSpec

DURATION_S = 200.0
N_VEHICLES = 4
SPACING_M = FlockingParams().spacing_m
SEEDS = tuple(range(611, 621))
"""Each draws other starts, losses and noise; none was used to choose a parameter."""
FIRST_LOOK_SEEDS = 6
"""How many of them fly by default, enough for the verdicts; `--seeds 10` flies all."""

_FREE = "environment.obstacles=[]"
_POTENTIAL = (
    "agent.hold_s=10.0",
    "agent.flocking={kind: potential, params: {path_gain_ps: 0.1, bandwidth_ratio: 0.2, followers: blind}}",
    "agent.flocking.params.leader_steers=centre",
    "agent.flocking.params.feedforward=flock",
    "agent.flocking.params.correction_limit_mps=0.2",
    "agent.consensus={kind: thesis, params: {rate_ps: 1.0, follow_flock: true}}",
)
_KIND, _PARAMS = "agent.separation.kind", "agent.separation.params"
_WIDE_PEAKS_M = (-5.0, -0.25, 0.0, 0.25, 5.0)

ATTRACTION_PS = attraction_ps(FlockingParams(), N_VEHICLES, followers_know_path=False)
_OWN = {
    "fuzzy": fuzzy.Separation(fuzzy.Params(input_peaks_m=_WIDE_PEAKS_M)),
    "narrow fuzzy": fuzzy.Separation(fuzzy.Params()),
    "mathematical": mathematical_law(1.0),
}
STIFFNESS_PS = {
    name: resting_stiffness_ps(law, ATTRACTION_PS, N_VEHICLES, SPACING_M) for name, law in _OWN.items()
}
"""Stiffness of each law (1/s, before the flock's bandwidth ratio) where its flock rests."""
STIFFNESS_PS["adaptive fuzzy"] = stiffness_ps(
    adaptive_fuzzy.Separation(adaptive_fuzzy.Params()), SPACING_M, SPACING_M
)
GAINS = {
    name: gain_for_stiffness(STIFFNESS_PS[name], ATTRACTION_PS, N_VEHICLES, SPACING_M)
    for name in ("fuzzy", "narrow fuzzy")
}
"""The gains with which the mathematical law is as stiff as each of these laws."""


def _resting_at_m(distance_m: float, wanted_ps: float) -> tuple[float, float]:
    """Return gain and spacing (m) of the mathematical law that rests at a distance with a stiffness."""

    def gain_of(spacing_m: float) -> float:
        return gain_for_distance(distance_m, ATTRACTION_PS, N_VEHICLES, spacing_m)

    def surplus_ps(spacing_m: float) -> float:
        return stiffness_ps(mathematical_law(gain_of(spacing_m)), distance_m, spacing_m) - wanted_ps

    spacing_m = float(brentq(surplus_ps, 1.001 * distance_m, 2.0 * distance_m))
    return gain_of(spacing_m), spacing_m


CORRECTED_GAIN, WIDER_M = _resting_at_m(SPACING_M, STIFFNESS_PS["adaptive fuzzy"])


def _mathematical(gain: float) -> tuple[str, ...]:
    return (f"{_KIND}=mathematical", f"{_PARAMS}.gain={gain:.6g}")


LAWS: dict[str, tuple[str, ...]] = {
    "mathematical": (f"{_KIND}=mathematical",),
    "fuzzy": (f"{_KIND}=fuzzy", f"{_PARAMS}.input_peaks_m={list(_WIDE_PEAKS_M)}"),
    "mathematical, as stiff as fuzzy": _mathematical(GAINS["fuzzy"]),
    "adaptive fuzzy": (f"{_KIND}=adaptive_fuzzy",),
    "mathematical, as stiff as adaptive fuzzy, spacing corrected": (
        *_mathematical(CORRECTED_GAIN),
        f"agent.flocking.params.spacing_m={WIDER_M:.6g}",
    ),
}
NARROW_LAWS: dict[str, tuple[str, ...]] = {
    "fuzzy with the sets that give the thesis's distances": (f"{_KIND}=fuzzy",),
    "mathematical, as stiff as these sets": _mathematical(GAINS["narrow fuzzy"]),
}


def _plant(factor: float) -> tuple[str, ...]:
    """Return the vehicles with inertia, added mass and drag scaled by a factor; gains stay the same."""
    numbers: dict[str, float | list[float]] = {
        "mass_kg": 125.0,
        "inertia_kgm2": [8.0, 8.0, 8.0],
        "added_mass": [62.5, 62.5, 62.5, 0.0, 0.0, 0.0],
    }
    scaled = {
        name: round(factor * value, 6)
        if isinstance(value, float)
        else [round(factor * item, 6) for item in value]
        for name, value in numbers.items()
    }
    hulls = tuple(
        f"vehicles.{index}.model.params.{name}={value}"
        for index in range(N_VEHICLES)
        for name, value in scaled.items()
    )
    return (*hulls, *damping(factor))


def damping(factor: float) -> tuple[str, ...]:
    """Return the vehicles with their drag scaled by a factor, which no law or controller learns."""
    drag = [round(factor * value, 6) for value in (48.0, 48.0, 48.0, 80.0, 80.0, 80.0)]
    return tuple(f"vehicles.{index}.model.params.quadratic_damping={drag}" for index in range(N_VEHICLES))


def _limit(force_n: float) -> tuple[str, ...]:
    """Return thrusters with this force limit, which the controllers know."""
    wrench = [force_n] * 3 + [50.0] * 3
    hulls = tuple(f"vehicles.{index}.model.params.max_wrench={wrench}" for index in range(N_VEHICLES))
    return (*hulls, f"agent.controller.params.max_force_n={force_n}")


NOMINAL, NOISE = "nominal (0.05 m/s current, 150 N)", "noise 5 cm, 1 cm/s"
CONDITIONS: dict[str, tuple[str, ...]] = {
    NOMINAL: (),
    "plant + 30 %": _plant(1.3),
    "plant - 30 %": _plant(0.7),
    "current 0.1 m/s": ("environment.current_ned_mps=[0.08,0.06,0.0]",),
    NOISE: ("environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.01}}",),
    "forces up to 200 N": _limit(200.0),
    "forces up to 20 N": _limit(20.0),
}


def spec_of(law: tuple[str, ...], condition: tuple[str, ...], seed: int | None = None) -> RunSpec:
    """Return a run of 200 s; one with a seed of `SEEDS` keeps metrics only."""
    changes = (_FREE, *_POTENTIAL, *law, *condition)
    if seed is None:
        return RunSpec("flock_acoustic", changes, DURATION_S)
    index = SEEDS.index(seed)
    return RunSpec(
        "flock_acoustic",
        (*changes, f"seed={seed}"),
        DURATION_S,
        keep_recording=False,
        nth=0 if index < FIRST_LOOK_SEEDS else index,
    )


RUNS = {
    (law, condition): spec_of(LAWS[law], changes)
    for condition, changes in CONDITIONS.items()
    for law in tuple(LAWS)[:4]
}
NARROW = {law: spec_of(overrides, ()) for law, overrides in NARROW_LAWS.items()}
DRAWN = {
    (law, condition): tuple(spec_of(overrides, CONDITIONS[condition], seed) for seed in SEEDS)
    for condition in (NOMINAL, NOISE)
    for law, overrides in LAWS.items()
    if (law, condition) != ("mathematical", NOISE)
}
"""The same laws with other draws of starts, losses and noise."""
NARROW_DRAWN = {
    law: tuple(spec_of(overrides, (), seed) for seed in SEEDS) for law, overrides in NARROW_LAWS.items()
}
