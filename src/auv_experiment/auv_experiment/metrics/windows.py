"""Times after which quantities of a run count, when a flock has gathered and later, and bins of ages."""

from __future__ import annotations

from auv_experiment.recording import BoolArray, FloatArray

SETTLED_AFTER_S = 100.0
GATHERED_AFTER_S = 150.0
LATE_AFTER_S = 200.0
COORDINATED_AFTER_S = 700.0
TIME_TOLERANCE_S = 1e-9

AGES_S = (0, 2, 5, 10, 20)
"""Lower ends of bins of the ages of information (s); the last one is open."""


def after(t_s: FloatArray, start_s: float) -> BoolArray:
    """Return which times are later than `start_s` by more than rounding."""
    return t_s > start_s + TIME_TOLERANCE_S


def age_words(index: int) -> str:
    """Return a bin of `AGES_S` in words."""
    if index == len(AGES_S) - 1:
        return f"{AGES_S[index]} s and more"
    return f"{AGES_S[index]} to {AGES_S[index + 1]} s"
