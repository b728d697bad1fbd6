"""
Runs that compare path-following laws on one plant: the vehicle of Table 2.1, body frame, drag d_Q |a| a.

A circle of 10 m at 0.1 m/s past an obstacle 0.57 m beside it, sampled at 10 Hz. The printed gains of PD and
augmented PD and the presets of the others differ by a factor of three in stiffness. The laws of the thesis
therefore fly once more with the feedback gains of the robust laws (`path_gains`). Noise is drawn ten times.
"""

from __future__ import annotations

from typing import Any

from auv_control.controllers import make_controller
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.items import RunSpec
from auv_thesis.laws.path_gains import Gains, feedback_gains

SCENARIO = "compare_path_laws"
_INERTIA = (215.0, 265.0, 265.0, 80.0)
_LINEAR = (70.0, 100.0, 100.0, 50.0)
_QUADRATIC = (100.0, 200.0, 200.0, 100.0)


def _numbers(values: tuple[float, ...], factor: float = 1.0) -> str:
    return str([round(factor * value, 6) for value in values])


def _scaled_plant(factor: float) -> tuple[str, ...]:
    names = {"inertia": _INERTIA, "linear_damping": _LINEAR, "quadratic_damping": _QUADRATIC}
    return tuple(
        f"vehicles.0.model.params.{name}={_numbers(values, factor)}" for name, values in names.items()
    )


LAWS = {
    "PD (pfpd)": "{kind: pfpd}",
    "augmented PD (pfapd)": "{kind: pfapd}",
    "adaptive": (
        "{preset: adaptive_corrected, params: {"
        f"nominal_inertia: {_numbers(_INERTIA)}, nominal_linear_damping: {_numbers(_LINEAR)}, "
        f"nominal_quadratic_damping: {_numbers(_QUADRATIC)}}}}}"
    ),
    "sliding mode": "{kind: sliding_mode}",
    "H-infinity": "{preset: h_infinity_table_2_1}",
}
ROBUST = ("sliding mode", "H-infinity")


def gains_of(controller: str) -> Gains:
    """Return the feedback gains of a controller of the scenario, given as in an override."""
    section = load_scenario(SCENARIO, overrides=(f"agent.controller={controller}",)).agent.controller
    made: Any = make_controller(section, 0.1)
    return feedback_gains(made)


GAINS = {law: gains_of(controller) for law, controller in LAWS.items()}


def _pd_as_stiff_as(kind: str, law: str) -> str:
    """Return PD or augmented PD with the gains of another law."""
    (k_x, k_y), (d_x, d_y) = GAINS[law]
    return (
        f"{{kind: {kind}, params: {{position_gain: {_numbers((k_x, k_y, 0.0))}, "
        f"velocity_gain: {_numbers((d_x, d_y, 0.0))}}}}}"
    )


def _adaptive_as_stiff_as(law: str) -> str:
    """Return the adaptive law with error gains that give the stiffness of another law in surge and sway."""
    (k_x, k_y), _ = GAINS[law]
    (own_x, own_y), _ = GAINS["adaptive"]
    own: Any = load_scenario(
        SCENARIO, overrides=(f"agent.controller={LAWS['adaptive']}",)
    ).agent.controller.params
    x, y, *rest = own.error_gain
    rate_x, rate_y, *_ = own.error_rate_ps
    stiff = (x + (k_x - own_x) / rate_x, y + (k_y - own_y) / rate_y, *rest)
    return LAWS["adaptive"].replace("params: {", f"params: {{error_gain: {_numbers(stiff)}, ", 1)


EQUAL = {
    "PD, as stiff as sliding mode": _pd_as_stiff_as("pfpd", "sliding mode"),
    "augmented PD, as stiff as sliding mode": _pd_as_stiff_as("pfapd", "sliding mode"),
    "adaptive, as stiff as sliding mode": _adaptive_as_stiff_as("sliding mode"),
    "augmented PD, as stiff as H-infinity": _pd_as_stiff_as("pfapd", "H-infinity"),
}
"""Laws of the thesis with the stiffness of the robust laws."""
RIVALS = {"sliding mode": tuple(EQUAL)[:3], "H-infinity": (tuple(EQUAL)[3], tuple(EQUAL)[2])}
"""The laws of the thesis that are about as stiff as each robust law."""
NOISE, LIMITS = "noise 5 cm, 1 cm/s", "limits 200 N"
CONDITIONS: dict[str, tuple[str, ...]] = {
    "nominal": (),
    "plant +30 %": _scaled_plant(1.3),
    "plant -30 %": _scaled_plant(0.7),
    "current 0.1 m/s": ("environment.current_ned_mps=[0.1, 0.0, 0.0]",),
    NOISE: ("environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.01}}",),
    LIMITS: ("vehicles.0.model.params.max_force_n=200.0",),
}
SEEDS = tuple(range(731, 741))
"""Each draws other noise."""


def _spec(controller: str, condition: str, *more: str) -> RunSpec:
    return RunSpec(SCENARIO, (f"agent.controller={controller}", *CONDITIONS[condition], *more))


ALL_LAWS = {**LAWS, **EQUAL}
CASES = [(law, condition) for law in ALL_LAWS for condition in CONDITIONS]
RUNS = tuple(_spec(ALL_LAWS[law], condition) for law, condition in CASES)
NOISY_LAWS = (*ROBUST, tuple(EQUAL)[1], tuple(EQUAL)[3])
NOISY = {law: tuple(_spec(ALL_LAWS[law], NOISE, f"seed={seed}") for seed in SEEDS) for law in NOISY_LAWS}
