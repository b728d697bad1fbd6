"""
Fixed-step integration: the classical Runge-Kutta scheme, once for every layout of a state.

`rk4` knows the scheme and nothing of the state: tuples of any length in plain Python (`rk4_step`), or the 13
floats of a hull, compiled (`auv_core.models.six_dof`).  The loop over the arrays of a whole fleet lists pairs
and writes a log between the stages, so it cannot call `rk4`; `put_along` and `put_step` are the same scheme
in place, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inlined

State = tuple[float, ...]
Floats = NDArray[np.float64]
X = TypeVar("X")


@inlined
def rk4(
    rate: Callable[[float, X, Any], X],
    along: Callable[[X, float, X], X],
    t_s: float,
    x: X,
    dt_s: float,
    given: Any,
) -> X:
    """
    Return a state after one step of `dt_s` from `t_s` on (s); the error of a step is of order dt^5.

    Parameters
    ----------
    rate : callable
        ``rate(t_s, x, given)``, the rate of change of a state.
    along : callable
        ``along(x, span, k)``, which is x + span k: all that a layout of states is.
    t_s, x, dt_s
        Time at the start of the step (s), the state at that time, and the length of the step (s).
    given
        What the rate needs besides; held over the step.

    """
    half_s = 0.5 * dt_s
    k1 = rate(t_s, x, given)
    k2 = rate(t_s + half_s, along(x, half_s, k1), given)
    k3 = rate(t_s + half_s, along(x, half_s, k2), given)
    k4 = rate(t_s + dt_s, along(x, dt_s, k3), given)
    slope = along(along(k1, 2.0, along(k2, 1.0, k3)), 1.0, k4)
    return along(x, dt_s / 6.0, slope)


def rk4_step(derivative: Callable[[float, State], State], t_s: float, state: State, dt_s: float) -> State:
    """
    Return a state that is a tuple of any length after one step of `rk4`.

    Parameters
    ----------
    derivative : callable
        ``derivative(t_s, state)``, the rate of change of every component.
    t_s, dt_s : float
        Time at the start of the step and its length (s).
    state : (n,) tuple of float
        State at `t_s`.

    """
    return rk4(_called, _along, t_s, state, dt_s, derivative)


def _called(t_s: float, state: State, derivative: Callable[[float, State], State]) -> State:
    return derivative(t_s, state)


def _along(x: State, span_s: float, k: State) -> State:
    return tuple([a + span_s * b for a, b in zip(x, k, strict=False)])


@inlined
def put_along(x: Floats, span_s: float, k: Floats, stage: int, there: Floats) -> None:
    """Write x + span k into `there`; x is (n, m), and `k` has the rates of all four stages, (4, n, m)."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            there[i, j] = x[i, j] + span_s * k[stage, i, j]


@inlined
def put_step(x: Floats, dt_s: float, k: Floats) -> None:
    """Move `x` (n, m) on by a step whose stages have the rates `k`, (4, n, m)."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] += dt_s / 6.0 * (k[0, i, j] + 2.0 * (k[1, i, j] + k[2, i, j]) + k[3, i, j])
