"""Drag of one axis, (d_L + d_Q |a|) a."""

from __future__ import annotations

import math


def steady_speed_mps(linear_nspm: float, quadratic_ns2pm2: float, force_n: float) -> float:
    """Return the speed at which the drag of an axis is `force_n` (m/s): infinite without drag or limit."""
    if not math.isfinite(force_n) or linear_nspm + quadratic_ns2pm2 == 0.0:
        return math.inf
    root = math.sqrt(linear_nspm * linear_nspm + 4.0 * quadratic_ns2pm2 * force_n)
    return 2.0 * force_n / (linear_nspm + root)
