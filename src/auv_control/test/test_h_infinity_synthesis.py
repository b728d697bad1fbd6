"""Claims about the synthesis: Riccati equation, smallest gain, norm of the loop, and the preset."""

from functools import cache
from importlib import import_module

import numpy as np
import pytest
import yaml
from scipy.linalg import expm

from auv_control.controllers.adaptive import Params as AdaptiveParams
from auv_control.controllers.formation_sliding_mode import Params as SlidingParams
from auv_control.controllers.velocity_pi import Params as PiParams
from auv_control.controllers.velocity_sliding_mode import Params as VelocitySlidingParams
from auv_control.synthesis.designs import designs
from auv_control.synthesis.h_infinity import (
    Weights,
    axis_plant,
    closed_loop,
    feedback,
    hamiltonian_norm,
    riccati_solution,
    sweep_norm,
    synthesise,
)
from auv_core.params import dump, load

WEIGHTS = Weights()
SURGE, SWAY = (215.0, 70.0, 100.0), (265.0, 100.0, 200.0)
both_axes = pytest.mark.parametrize("numbers", [SURGE, SWAY], ids=["surge", "sway"])


@cache
def _designs():
    return designs()


@cache
def _axes():
    return dict(zip((SURGE, SWAY), _designs()[0].axes.values(), strict=True))


@pytest.mark.parametrize("index", [0, 1, 2], ids=["path", "formation", "velocity"])
def test_preset_and_defaults_are_what_the_synthesis_gives(index):
    design = _designs()[index]
    stored = yaml.safe_load(design.file.read_text(encoding="utf-8"))
    assert stored["kind"] == design.kind
    assert stored["params"].keys() == design.params.keys()
    for key, values in design.params.items():
        assert stored["params"][key] == pytest.approx(values, rel=1e-6), key
    module = import_module(f"auv_control.controllers.{design.kind}")
    defaults = dump(load(module.Params, {}, "law"))
    assert {key: defaults[key] for key in design.params} == stored["params"]


def test_laws_that_are_compared_are_equally_stiff():
    adaptive, sliding = AdaptiveParams(), SlidingParams()
    stiffness = [float(axis.gain[0, 1]) for axis in _designs()[1].axes.values()]
    assert stiffness == pytest.approx(np.multiply(adaptive.error_gain, adaptive.error_rate_ps).tolist())
    in_the_layer = np.divide(sliding.switching_gain, sliding.boundary_layer)
    assert stiffness == pytest.approx((in_the_layer * sliding.error_rate_ps).tolist())
    pi, velocity_sliding = PiParams(), VelocitySlidingParams()
    rate_ps = velocity_sliding.error_rate_ps
    gain_nspm = velocity_sliding.switching_gain_n / velocity_sliding.boundary_layer_mps
    assert float(_designs()[2].axes["velocity"].gain[0, 1]) == pytest.approx(pi.velocity_gain_nspm)
    assert gain_nspm + velocity_sliding.mass_kg[0] * rate_ps == pytest.approx(pi.velocity_gain_nspm, rel=1e-3)
    assert gain_nspm * rate_ps == pytest.approx(pi.integral_gain_npm, rel=1e-3)


def _every_axis():
    return [axis for design in _designs() for axis in design.axes.values()]


def plant_of(numbers, factor=1.0):
    mass_kg, linear, quadratic = (factor * number for number in numbers)
    return axis_plant(mass_kg, linear, quadratic, WEIGHTS)


@both_axes
def test_riccati_solution_solves_its_equation(numbers):
    plant = plant_of(numbers)
    gamma = 0.9
    p = riccati_solution(plant, gamma)
    assert p is not None
    quadratic = plant.b1 @ plant.b1.T / gamma**2 - plant.b2 @ plant.b2.T / plant.r
    residual = plant.a.T @ p + p @ plant.a + plant.c.T @ plant.c + p @ quadratic @ p
    assert np.abs(residual).max() < 1e-6 * np.abs(p).max()
    loop, _, _ = closed_loop(plant, feedback(plant, p))
    assert np.linalg.eigvalsh(loop.T @ p + p @ loop).max() < 0.0, "x^T P x falls"


@both_axes
def test_smallest_gain_is_where_the_disturbance_must_be_answered(numbers):
    result = _axes()[numbers]
    assert result.gamma_best == pytest.approx(WEIGHTS.disturbance_n / WEIGHTS.force_n, rel=1e-4)
    assert riccati_solution(plant_of(numbers), 0.99 * result.gamma_best) is None


def test_norms_of_all_loops_found_twice_are_below_gamma():
    assert len(_every_axis()) == 7
    for result in _every_axis():
        assert result.norm_hamiltonian == pytest.approx(result.norm_sweep, rel=1e-5)
        assert result.gamma_best <= result.norm_hamiltonian <= result.gamma


def test_norms_by_hand():
    # 1 / (s + 2): 1/2 at w = 0; 1 / (s^2 + 0.2 s + 1): 1 / (0.2 sqrt(1 - 0.01)) at resonance
    first = (np.array([[-2.0]]), np.array([[1.0]]), np.array([[1.0]]))
    assert hamiltonian_norm(*first) == pytest.approx(0.5, rel=1e-4)
    second = (np.array([[0.0, 1.0], [-1.0, -0.2]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]))
    peak = 1.0 / (0.2 * np.sqrt(0.99))
    assert hamiltonian_norm(*second) == pytest.approx(peak, rel=1e-5)
    assert sweep_norm(*second) == pytest.approx(peak, rel=1e-4)


@both_axes
@pytest.mark.parametrize("factor", [0.7, 1.0, 1.3])
def test_sampled_loop_is_stable_for_vehicles_that_differ(numbers, factor):
    gain = _axes()[numbers].gain
    plant = plant_of(numbers, factor)
    period_s = 0.1
    held = expm(np.block([[plant.a, plant.b2], [np.zeros((1, 4))]]) * period_s)
    loop = held[:3, :3] + held[:3, 3:] @ gain
    assert np.abs(np.linalg.eigvals(loop)).max() < 1.0


def test_a_margin_below_one_is_refused():
    with pytest.raises(ValueError, match=r"^margin: 0\.9 is not allowed; allowed: a number above 1"):
        synthesise(axis_plant(*SURGE, WEIGHTS), 0.9)
