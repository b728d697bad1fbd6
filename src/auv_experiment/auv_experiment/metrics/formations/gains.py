"""Metrics of how errors grow along the strings and over the layers of a formation that keeps its shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from auv_experiment.metrics.formations.stability import (
    LEADER,
    gains_along_string,
    gains_from_leader,
    gains_over_layers,
    root_of_integral,
    spacing_errors_m,
    sup,
)
from auv_experiment.recording import FloatArray

_KEYS = ("string_gain_max", "string_gain_l2_max", "string_gain_leader_max", "mesh_gain_max")


def gain_metrics(
    positions: FloatArray, path: FloatArray, offsets: FloatArray, followed: Sequence[int], step_s: float
) -> dict[str, Any]:
    """
    Return the largest gains, thesis Eqs. (1.21) to (1.25); None without errors to compare.

    Parameters
    ----------
    positions, offsets : (K, N, D) arrays
        Positions and the world offsets of the slots (m); D is 3, or 1 along a path.
    path : (K, D) array
        Where the path is (m).
    followed : sequence of N int
        The vehicle that each one follows, `LEADER` for the leader.
    step_s : float
        Time from one instant to the next (s).

    """
    if not len(positions):
        return dict.fromkeys(_KEYS)
    errors_m = spacing_errors_m(positions, path, offsets, followed)
    ahead = [() if other == LEADER else (other,) for other in followed]
    gains = (
        gains_along_string(sup(errors_m), followed),
        gains_along_string(root_of_integral(errors_m, step_s), followed),
        gains_from_leader(sup(errors_m), followed),
        gains_over_layers(positions - offsets, ahead),
    )
    return {key: max(each, default=None) for key, each in zip(_KEYS, gains, strict=True)}
