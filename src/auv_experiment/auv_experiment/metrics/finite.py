"""Statistics of finite numbers: NaN and infinity do not count; without finite numbers the result is None."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from auv_experiment.recording import FloatArray


def norm(vectors: FloatArray) -> FloatArray:
    """Return the lengths of vectors along the last axis."""
    length: FloatArray = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    return length


def finite(values: FloatArray) -> FloatArray:
    """Return the finite values, as a row."""
    return values[np.isfinite(values)]


def smallest(values: FloatArray) -> float | None:
    """Return the smallest of the finite values."""
    known = finite(values)
    return float(known.min()) if known.size else None


def largest(values: FloatArray) -> float | None:
    """Return the largest of the finite values."""
    known = finite(values)
    return float(known.max()) if known.size else None


def mean(values: FloatArray) -> float | None:
    """Return the mean of the finite values."""
    known = finite(values)
    return float(known.mean()) if known.size else None


def rms(values: FloatArray) -> float | None:
    """Return the root mean square of the finite values."""
    known = finite(values)
    return float(np.sqrt(np.mean(known * known))) if known.size else None


def plain(value: Any) -> Any:
    """Turn NumPy scalars into Python ones and numbers that are not finite into None, in lists too."""
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
