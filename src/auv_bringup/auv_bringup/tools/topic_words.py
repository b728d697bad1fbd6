"""Messages and their rate as text, in the format of the ros2 command line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import yaml

MAX_ELEMENTS = 128


def describe_rate(arrivals_s: Sequence[float]) -> str:
    """Return the average rate of arrivals and the spread of the intervals, in the format of `ros2 topic hz`.

    Parameters
    ----------
    arrivals_s
        Two or more arrival times (s), oldest first.
    """
    intervals_s = np.diff(np.array(arrivals_s))
    mean_s = float(intervals_s.mean())
    rate_hz = 1.0 / mean_s if mean_s > 0.0 else float("inf")
    return (
        f"average rate: {rate_hz:.3f}\n\tmin: {intervals_s.min():.3f}s max: {intervals_s.max():.3f}s "
        f"std dev: {intervals_s.std():.5f}s window: {len(intervals_s)}"
    )


def message_to_yaml(message: Any) -> str:
    """Return a message as block-style YAML; long arrays are truncated with '...'."""
    return yaml.safe_dump(
        _plain(message), sort_keys=False, allow_unicode=True, default_flow_style=False, width=1000
    )


def _plain(value: Any) -> Any:
    """Return a message, or a field of one, as plain Python values."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: _plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, bytes):
        return list(value)
    if isinstance(value, str | bool | int | float):
        return value
    items = [_plain(each) for each in value[:MAX_ELEMENTS]]
    return [*items, "..."] if len(value) > MAX_ELEMENTS else items
