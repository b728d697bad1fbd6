"""A run for the figures of a flock: data that several of them need, and the names of the lines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from auv_experiment.figures.plotting import MAX_LINES, marker, vehicle_style
from auv_experiment.metrics.distances import centroid_ned_m, flock_positions_ned_m, path_ned_m
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


@dataclass(frozen=True, eq=False)
class FlockRun:
    """A recording and its scenario, with data that several figures need."""

    recording: Recording
    scenario: Scenario

    @cached_property
    def t_s(self) -> FloatArray:
        """Scenario times of the states (s)."""
        return self.recording.t_s

    @cached_property
    def path_ned_m(self) -> FloatArray:
        """The (K + 1, 3) positions of the path (m, map_ned)."""
        return path_ned_m(self.recording, self.scenario)

    @cached_property
    def centroid_ned_m(self) -> FloatArray:
        """The (K + 1, 3) mean of the flock's positions (m, map_ned)."""
        return centroid_ned_m(self.recording)

    @cached_property
    def flock_ned_m(self) -> FloatArray:
        """The (K + 1, N, 3) positions, NaN after a vehicle's loss (m, map_ned)."""
        return flock_positions_ned_m(self.recording)

    @cached_property
    def labels(self) -> list[str]:
        """Vehicle names; leaders are marked unless every vehicle is one."""
        ids, leaders = self.recording.vehicle_ids, set(self.scenario.leaders)
        is_mixed = 0 < len(leaders) < len(ids)
        return [f"{name} (leader)" if is_mixed and name in leaders else name for name in ids]


def path_handle() -> Line2D:
    """Return the path's line for a legend."""
    return Line2D([], [], color="0.55", linewidth=3.0, alpha=0.55, label="path")


def vehicle_handles(run: FlockRun) -> list[Line2D]:
    """Return the vehicles' lines for a legend, none if there are too many to distinguish."""
    if run.recording.n_vehicles > MAX_LINES:
        return []
    return [
        Line2D([], [], marker=marker(i), label=label, **vehicle_style(i))
        for i, label in enumerate(run.labels)
    ]
