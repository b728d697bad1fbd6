"""Claims about the fuzzy inference and its table."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skfuzzy.defuzzify import defuzz
from skfuzzy.membership import trimf

from auv_flocking.mamdani import FINE_STEPS, Curve, curve, infer

MODERATE = settings(max_examples=25, deadline=None)
THESIS_LIKE = ((-5.0, -0.045, 0.0, 0.045, 5.0), (-2.0, -1.0, 0.0, 1.0, 2.0))
LOPSIDED = ((-3.0, -1.0, 0.2, 0.5, 4.0), (-2.0, -1.9, -0.8, 0.3, 2.0))
CURVES = pytest.mark.parametrize(("inputs", "outputs"), [THESIS_LIKE, LOPSIDED], ids=["thesis", "lopsided"])
RISES = st.tuples(*[st.floats(0.01, 3.0)] * 5).map(lambda steps: tuple(np.cumsum(steps).tolist()))


def _textbook(x, inputs, outputs):
    """Infer on a universe of four thousand points, without a thought for corners."""
    universe = np.linspace(outputs[0], outputs[4], 4001)
    feet = [(0, 0, 1), (0, 1, 2), (1, 2, 3), (2, 3, 4), (3, 4, 4)]
    aggregated = np.zeros_like(universe)
    for k in feet:
        degree = trimf(np.array([x]), [inputs[i] for i in k])[0]
        implied = np.fmin(degree, trimf(universe, [outputs[i] for i in k]))
        aggregated = np.fmax(aggregated, implied)
    return defuzz(universe, aggregated, "centroid")


@CURVES
def test_direct_inference_is_what_the_textbook_says(inputs, outputs):
    for x in np.linspace(inputs[0], inputs[4], 23).tolist():
        assert infer(x, inputs, outputs) == pytest.approx(_textbook(x, inputs, outputs), abs=2e-6)


@CURVES
def test_the_table_is_the_direct_inference(inputs, outputs):
    """Random inputs, and as many in the narrowest set."""
    rng = np.random.default_rng(1)
    x = np.concatenate(
        [rng.uniform(inputs[0] - 1, inputs[4] + 1, 200), rng.uniform(inputs[1], inputs[3], 200)]
    )
    tabulated = [curve(inputs, outputs).at(value) for value in x.tolist()]
    direct = [infer(value, inputs, outputs) for value in x.tolist()]
    np.testing.assert_allclose(tabulated, direct, rtol=0.0, atol=2e-4 * (outputs[4] - outputs[0]))


def test_a_finer_table_is_nearer_to_direct_inference():
    x = np.random.default_rng(2).uniform(-0.05, 0.05, 200).tolist()
    direct = np.array([infer(value, *THESIS_LIKE) for value in x])
    tables = [Curve(*THESIS_LIKE, steps) for steps in (8, 64)]
    errors = [np.abs(np.array([table.at(value) for value in x]) - direct).max() for table in tables]
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize(
    ("x", "output"),
    [(0.0, 0.0), (0.045, 1.0), (-0.045, -1.0), (5.0, 5.0 / 3.0), (-5.0, -5.0 / 3.0), (-9.0, -5.0 / 3.0)],
)
def test_outputs_worked_by_hand(x, output):
    """One set holds fully at its peak: the centroid of a whole triangle, and of half a one at the ends."""
    assert infer(x, *THESIS_LIKE) == pytest.approx(output, abs=1e-12)
    assert curve(*THESIS_LIKE).at(x) == pytest.approx(output, abs=1e-12)


def test_half_way_between_two_sets_by_hand():
    """Z and P cut at one half make a trapezoid from -1 to 2, symmetric about one half."""
    assert infer(0.0225, *THESIS_LIKE) == pytest.approx(0.5, abs=1e-12)


def test_symmetric_peaks_give_an_odd_curve():
    at = curve(*THESIS_LIKE).at
    for x in np.linspace(0.0, 6.0, 301).tolist():
        assert at(x) == pytest.approx(-at(-x), abs=1e-12)


@MODERATE
@given(RISES, st.floats(0.1, 2.0), st.floats(-3.0, 3.0))
def test_more_in_never_gives_less_out_of_even_peaks(inputs, step, middle):
    """The thesis: "if the input is less, the output is less and if the input is more, the output is more"."""
    outputs = tuple(middle + k * step for k in (-2.0, -1.0, 0.0, 1.0, 2.0))
    made = Curve(inputs, outputs, 8)
    values = [made.at(x) for x in np.linspace(inputs[0] - 1.0, inputs[4] + 1.0, 97).tolist()]
    assert np.diff(values).min() >= -1e-9
    assert outputs[0] <= values[0] <= values[-1] <= outputs[4]


@CURVES
def test_the_integral_has_the_curve_as_its_slope(inputs, outputs):
    made, step = Curve(inputs, outputs, FINE_STEPS), 1e-6
    for x in np.linspace(inputs[0] - 0.5, inputs[4] + 0.5, 60).tolist():
        slope = (made.integral(x + step) - made.integral(x - step)) / (2.0 * step)
        assert slope == pytest.approx(made.at(x), abs=1e-4)


def test_peaks_that_are_not_even_can_give_less_out_for_more_in():
    """So the evenness above is not idle."""
    made = Curve((1.0, 2.0, 3.0, 4.0, 5.0), (1.0, 2.0, 3.0, 5.0, 5.5), 8)
    assert np.diff([made.at(x) for x in np.linspace(0.0, 6.0, 97).tolist()]).min() < -1e-3


def test_moving_the_output_peaks_moves_the_curve_by_as_much():
    inputs, outputs = LOPSIDED
    moved: Any = tuple(peak + 0.7 for peak in outputs)
    for x in np.linspace(inputs[0], inputs[4], 29).tolist():
        assert infer(x, inputs, moved) == pytest.approx(infer(x, inputs, outputs) + 0.7, abs=1e-12)


def test_the_same_peaks_are_tabulated_once():
    assert curve(*THESIS_LIKE) is curve(*THESIS_LIKE)
