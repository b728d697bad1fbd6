"""
The track of one neighbour: its measurements in the order of their times.

A packet arrives seconds after its time tag, and by then the sonar may have seen its sender. Therefore the
measurements of the last `HISTORY_S` are kept, each with the estimate after it. A late measurement is inserted
at its time, and the later ones are used again. A measurement in order costs a single update, and estimates
are kept by reference.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import fastest
from auv_flocking.heard import within_s
from auv_flocking.neighbours.estimates import (
    SOURCE_WIDTH,
    WIDTH,
    Estimates,
    NeighbourEstimate,
    carried_to,
    write_source,
)
from auv_flocking.neighbours.filter import Belief, NeighbourFilter
from auv_flocking.neighbours.navigation_offset import OwnFix, Stated
from auv_flocking.neighbours.sonar_contact import Sighting
from auv_flocking.report import Report

Matrix = NDArray[np.float64]

HISTORY_S = 20.0
MOST_MEASUREMENTS = 128


class HeardReport(NamedTuple):
    """
    A packet as a measurement: its content at its time tag, and the stated variances of both navigations.
    """

    report: Report
    stated: Stated

    @property
    def time_s(self) -> float:
        """The time tag (s)."""
        return self.report.time_s


Measurement = OwnFix | HeardReport | Sighting
_ORDER = {OwnFix: 0, HeardReport: 1, Sighting: 2}


class Track:
    """
    The measurements of one neighbour and the resulting estimate.

    After a measurement: `report` is the newest packet by time tag, `seen_s` the time of the newest contact
    (-inf: none), `belief` the estimate at the time of the newest measurement.
    """

    def __init__(self, heard: HeardReport, neighbour_filter: NeighbourFilter, memory_s: float) -> None:
        self._filter = neighbour_filter
        self._memory_s = memory_s
        self._write_source = fastest(write_source)
        self._measurements: list[Measurement] = [heard]
        self._beliefs = [neighbour_filter.first(heard.report, heard.stated)]
        self._is_whole = True
        self.report = heard.report
        self.seen_s = -math.inf

    @property
    def belief(self) -> Belief:
        """The estimate at the time of the newest measurement."""
        return self._beliefs[-1]

    def nis(self, time_s: float, numbers: int) -> float:
        """
        Return the normalised innovation squared of the measurement at this time with `size` numbers.

        NaN if it is not kept, and for the first packet, which has no prediction.
        """
        for belief in self._beliefs:
            if (
                belief.time_s == time_s
                and belief.innovation is not None
                and len(belief.innovation) == numbers
            ):
                return belief.nis
        return math.nan

    def hear(self, heard: HeardReport) -> bool:
        """
        Use a packet at its time; return whether it could be used.

        A repetition, or a packet older than the history, cannot be used.
        """
        if heard.time_s == self.report.time_s:
            return False
        if heard.time_s < self.report.time_s and any(
            isinstance(other, HeardReport) and other.time_s == heard.time_s for other in self._measurements
        ):
            return False
        if not self._insert(heard):
            return False
        if heard.time_s > self.report.time_s:
            self.report = heard.report
        return True

    def see(self, sighting: Sighting) -> None:
        """Use a contact that was associated with this neighbour."""
        if self._insert(sighting):
            self.seen_s = max(self.seen_s, sighting.time_s)

    def move_frame(self, fix: OwnFix) -> None:
        """Move the track into the frame of the own navigation after a fix."""
        self._insert(fix)

    def write(self, source: Matrix) -> None:
        """Write the estimate into a source row for `estimates.carried_to`."""
        report, belief = self.report, self._beliefs[-1]
        said = (
            report.time_s,
            *report.centre,
            *report.flock_velocity,
            report.flock_stamp_s,
            0.0 if math.isnan(report.flock_turn_rate_radps) else report.flock_turn_rate_radps,
            report.heading_rad,
            report.position_sd_m,
            1.0 if report.is_holding else 0.0,
            within_s(report.heard_code or 0),
            float(report.heard_mask or 0),
        )
        self._write_source(
            source, belief.time_s, belief.x, belief.P, belief.psd, belief.flock, said, self.seen_s
        )

    def estimate(self, t_s: float) -> NeighbourEstimate:
        """Return the estimate of the neighbour at `t_s`."""
        source, row = np.empty((1, SOURCE_WIDTH)), np.empty((1, WIDTH))
        self.write(source[0])
        carried_to(t_s, self._memory_s, math.inf, source, row, np.empty(1, dtype=np.int64))
        return Estimates([self.report.address], row, [self.report.shared])[0]

    def _insert(self, measurement: Measurement) -> bool:
        """
        Insert a measurement at its time and use it and all later ones; return whether it is within the
        history.
        """
        measurements, beliefs = self._measurements, self._beliefs
        place = len(measurements)
        key = (measurement.time_s, _ORDER[type(measurement)])
        while place > 0 and _key(measurements[place - 1]) > key:
            place -= 1
        if place == 0 and not (self._is_whole and isinstance(measurement, HeardReport)):
            return False
        measurements.insert(place, measurement)
        del beliefs[place:]
        for later in measurements[place:]:
            beliefs.append(self._next(beliefs[-1] if beliefs else None, later))
        self._forget()
        return True

    def _next(self, belief: Belief | None, measurement: Measurement) -> Belief:
        if isinstance(measurement, HeardReport):
            if belief is None:
                return self._filter.first(measurement.report, measurement.stated)
            return self._filter.after_packet(belief, measurement.report, measurement.stated)
        if belief is None:
            raise RuntimeError("a track begins with a packet")
        if isinstance(measurement, Sighting):
            return self._filter.after_sighting(belief, measurement)
        return self._filter.after_own_fix(belief, measurement)

    def _forget(self) -> None:
        """Drop measurements older than the history, except the newest."""
        measurements = self._measurements
        oldest_s = measurements[-1].time_s - HISTORY_S
        n = 0
        while n < len(measurements) - 1 and (
            measurements[n].time_s < oldest_s or len(measurements) - n > MOST_MEASUREMENTS
        ):
            n += 1
        if n:
            del measurements[:n], self._beliefs[:n]
            self._is_whole = False


def _key(measurement: Measurement) -> tuple[float, int]:
    return measurement.time_s, _ORDER[type(measurement)]
