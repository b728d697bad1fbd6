"""Claims about the integrator, compared with known solutions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_core.integrate import put_along, put_step, rk4_step

NUMBERS = st.floats(-1e3, 1e3)


def _oscillator_error(steps):
    """Return the error at t = 2 of y'' = -y + t, y(0) = 1, y'(0) = 0, whose solution is cos t - sin t + t."""
    dt_s = 2.0 / steps
    state: tuple[float, ...] = (1.0, 0.0)
    for step in range(steps):
        state = rk4_step(lambda t_s, y: (y[1], t_s - y[0]), step * dt_s, state, dt_s)
    exact = (math.cos(2.0) - math.sin(2.0) + 2.0, -math.sin(2.0) - math.cos(2.0) + 1.0)
    return math.dist(state, exact)


def test_rk4_is_of_order_four():
    errors = [_oscillator_error(steps) for steps in (20, 40, 80)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(4.0, abs=0.15)


def test_one_step_is_exact_for_a_cubic_in_time():
    (after,) = rk4_step(lambda t_s, _y: (4.0 * t_s**3 - t_s,), 1.0, (0.0,), 2.0)
    assert after == pytest.approx((81.0 - 1.0) - (9.0 - 1.0) / 2.0)


def test_the_given_state_is_not_changed_and_the_length_is_kept():
    state = (1.0, 2.0, 3.0)
    assert len(rk4_step(lambda _t_s, y: tuple(-x for x in y), 0.0, state, 0.1)) == 3
    assert state == (1.0, 2.0, 3.0)


@given(st.lists(st.lists(NUMBERS, min_size=3, max_size=3), min_size=1, max_size=4), st.floats(1e-3, 0.5))
def test_arrays_are_stepped_as_tuples_are_to_the_last_bit(rows, dt_s):
    x = np.array(rows)

    def rate(values):
        return [
            math.sin(value) - 0.3 * other
            for value, other in zip(values, values[1:] + values[:1], strict=True)
        ]

    by_tuple = rk4_step(lambda _t_s, y: tuple(rate(list(y))), 0.0, tuple(x.ravel().tolist()), dt_s)
    k, there = np.zeros((4, *x.shape)), x.copy()
    for stage, span_s in enumerate((0.0, 0.5 * dt_s, 0.5 * dt_s, dt_s)):
        if stage:
            put_along(x, span_s, k, stage - 1, there)
        k[stage] = np.array(rate(there.ravel().tolist())).reshape(x.shape)
    put_step(x, dt_s, k)
    assert tuple(x.ravel().tolist()) == by_tuple
