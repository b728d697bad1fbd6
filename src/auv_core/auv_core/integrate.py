"""Fixed-step integration of states that are tuples of floats."""

from __future__ import annotations

from collections.abc import Callable

State = tuple[float, ...]


def rk4_step(derivative: Callable[[float, State], State], t_s: float, state: State, dt_s: float) -> State:
    """
    Return the state after one classical Runge-Kutta step; the error of a step is of order dt^5.

    Parameters
    ----------
    derivative : callable
        ``derivative(t_s, state)``, the rate of change of every component.
    t_s, dt_s : float
        Time at the start of the step and its length (s).
    state : (n,) tuple of float
        State at `t_s`.

    """
    half = 0.5 * dt_s
    k1 = derivative(t_s, state)
    k2 = derivative(t_s + half, tuple([x + half * k for x, k in zip(state, k1, strict=False)]))
    k3 = derivative(t_s + half, tuple([x + half * k for x, k in zip(state, k2, strict=False)]))
    k4 = derivative(t_s + dt_s, tuple([x + dt_s * k for x, k in zip(state, k3, strict=False)]))
    sixth = dt_s / 6.0
    return tuple(
        [x + sixth * (a + 2.0 * (b + c) + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4, strict=False)]
    )
