"""
A start without a jump: the reference starts at the vehicle and moves smoothly to the path.

With the offset o = eta(0) - eta_ref(0) the law follows eta_d = eta_ref + b o, where b falls from 1 to 0 as
the quintic 1 - (10 q^3 - 15 q^4 + 6 q^5), q = t / T_b, whose first two derivatives vanish at both ends.
"""

from __future__ import annotations

import math


def blend(t_s: float, duration_s: float) -> tuple[float, float, float]:
    """
    Return the remaining share b of the start offset at `t_s`, with b' (1/s) and b'' (1/s^2).

    Before 0 it is (1, 0, 0), after `duration_s` (0, 0, 0).
    """
    if t_s >= duration_s:
        return (0.0, 0.0, 0.0)
    if t_s <= 0.0:
        return (1.0, 0.0, 0.0)
    q = t_s / duration_s
    left = 1.0 - q
    return (
        1.0 - q * q * q * (10.0 - q * (15.0 - 6.0 * q)),
        -30.0 * q * q * left * left / duration_s,
        -60.0 * q * left * (left - q) / (duration_s * duration_s),
    )


def wrapped(angle_rad: float) -> float:
    """Return the angle in (-pi, pi] (rad)."""
    turned = math.remainder(angle_rad, 2.0 * math.pi)
    return turned if turned > -math.pi else turned + 2.0 * math.pi
