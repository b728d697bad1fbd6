"""Claims about the integrator, held against equations with known solutions."""

import math

import numpy as np
import pytest

from auv_core.integrate import rk4_step


def _oscillator_error(steps):
    """Return the error at t = 2 of y'' = -y + t, y(0) = 1, y'(0) = 0, whose solution is cos t - sin t + t."""
    dt_s = 2.0 / steps
    state = (1.0, 0.0)
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
