"""Hulls seen from above, to scale and with their headings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Ellipse

from auv_experiment.figures.plotting import colour
from auv_experiment.recording import Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_ARROW_POINTS = 11.0
_ARROWHEAD = ((0.0, 1.0), (0.45, -0.6), (0.0, -0.35), (-0.45, -0.6), (0.0, 1.0))
"""Corners to starboard and ahead."""


def plot_hulls(axes: Any, recording: Recording, scenario: Scenario, tick: int) -> None:
    """Plot the hulls at a tick to scale, each with a line that points ahead."""
    for i, (handling, (north, east, _)) in enumerate(
        zip(scenario.handlings, recording.position_ned_m[tick], strict=True)
    ):
        ahead_north, ahead_east = _ahead(recording, tick, i)
        length_m, width_m = handling.hull_length_m, handling.hull_diameter_m
        from_east_deg = math.degrees(math.atan2(ahead_north, ahead_east))
        axes.add_patch(
            Ellipse(
                (east, north), length_m, width_m, angle=from_east_deg,
                facecolor=colour(i), edgecolor="white", zorder=5,
            )
        )  # fmt: skip
        tip = (east + length_m * ahead_east, north + length_m * ahead_north)
        axes.plot([east, tip[0]], [north, tip[1]], color=colour(i), linewidth=1.0, zorder=5)


def plot_headings(axes: Any, recording: Recording, tick: int) -> None:
    """Plot an arrowhead at each vehicle at a tick, for maps on which a hull to scale cannot be seen."""
    for i, (north, east, _) in enumerate(recording.position_ned_m[tick]):
        ahead_north, ahead_east = _ahead(recording, tick, i)
        n, e = np.array((ahead_north, ahead_east)) / max(math.hypot(ahead_north, ahead_east), 1e-9)
        head = [(x * n + y * e, y * n - x * e) for x, y in _ARROWHEAD]
        axes.plot(
            [east], [north], marker=head, markersize=_ARROW_POINTS,
            color=colour(i), markeredgecolor="white", linestyle="none", zorder=6,
        )  # fmt: skip


def _ahead(recording: Recording, tick: int, index: int) -> tuple[float, float]:
    """Return the body's forward axis, north and east."""
    w, x, y, z = recording.attitude_quat_wxyz[tick, index].tolist()
    return 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)
