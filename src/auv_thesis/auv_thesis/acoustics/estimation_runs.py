"""
Runs that compare the neighbour filters with the two simplest estimators.

Hold: the neighbour is at the position in its last packet. Dead reckoning: it has moved on from there with
the velocity in that packet. Both are computed from the packets of the recording. The filters' estimates were
recorded in flight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from auv_core.geometry import Vec3, body_to_ned
from auv_experiment.metrics.acoustics import relative_position_error_ned_m
from auv_experiment.recording import FloatArray, Recording
from auv_flocking.neighbours.table import NeighbourConfig, NeighbourTable
from auv_flocking.report import Report
from auv_thesis.items import Run, RunSpec

DURATION_S = 300.0
FORMED_S = 150.0
SLOTS_S = (0.25, 0.5, 1.0, 2.0)
LOSSES = (0.0, 0.3, 0.6)
SEEDS = tuple(range(131, 141))

EVERY_TICKS = 5
_POSITION_STEP_M, _VELOCITY_STEP_MPS = 0.02, 0.0025
_ZERO: Vec3 = (0.0, 0.0, 0.0)

_FILTER = (
    "agent.neighbours.acceleration_memory_s=60.0",
    "agent.neighbours.velocity_memory_s=15.0",
)
DRIFT = "environment.navigation={kind: dead_reckoning}"
_FIXES = "environment.navigation={kind: dead_reckoning, params: {fix: lbl, fix_period_s: 60.0}}"
_SONAR = "acoustics.sonar={kind: active}"


def spec_of(slot_s: float, loss_prob: float, *changes: str, seed: int = SEEDS[0], nth: int = 0) -> RunSpec:
    """Return the main job's flock without obstacles on a channel, with changes."""
    return RunSpec(
        "flock_acoustic",
        (
            "environment.obstacles=[]",
            f"seed={seed}",
            f"acoustics.mac.params.slot_s={slot_s}",
            f"acoustics.outage.params.loss_prob={loss_prob}",
            *_FILTER,
            *changes,
        ),
        DURATION_S,
        nth=nth,
    )


def _flights(slot_s: float, loss_prob: float) -> tuple[RunSpec, ...]:
    return tuple(spec_of(slot_s, loss_prob, seed=seed, nth=nth) for nth, seed in enumerate(SEEDS))


GRID = {(slot_s, loss): _flights(slot_s, loss) for loss in LOSSES for slot_s in SLOTS_S}
"""A study of many seeds in each cell of slot length (s) and loss."""
BAR = tuple(spec_of(2.0, 0.3, seed=seed) for seed in SEEDS[:3])
DRIFTING = {
    "exact navigation": spec_of(0.5, 0.3),
    "exact navigation, sonar": spec_of(0.5, 0.3, _SONAR),
    "drift": spec_of(0.5, 0.3, DRIFT),
    "drift, fixes every 60 s": spec_of(0.5, 0.3, _FIXES),
    "drift, sonar": spec_of(0.5, 0.3, DRIFT, _SONAR),
    "drift, fixes every 60 s, sonar": spec_of(0.5, 0.3, _FIXES, _SONAR),
    "drift, sonar, 2 s slots": spec_of(2.0, 0.3, DRIFT, _SONAR),
}


@dataclass(frozen=True)
class Errors:
    """
    Errors of many neighbours at many instants, one row each.

    `t_s` (M,), `age_s` (M,): instant and age of the newest packet (s); `ekf_m`, `hold_m`, `reckoned_m` (M,
    3) (m; NED); `covariance` (M, 3, 3): the filter's covariance of `ekf_m` (m^2).
    """

    t_s: FloatArray
    age_s: FloatArray
    ekf_m: FloatArray
    hold_m: FloatArray
    reckoned_m: FloatArray
    covariance: FloatArray

    def between(self, from_s: float, to_s: float) -> Errors:
        """Return the rows between two times (s)."""
        rows = (self.t_s >= from_s) & (self.t_s < to_s)
        return Errors(
            self.t_s[rows],
            self.age_s[rows],
            self.ekf_m[rows],
            self.hold_m[rows],
            self.reckoned_m[rows],
            self.covariance[rows],
        )

    @property
    def said_m(self) -> float:
        """Root mean square position error according to the filter's covariance (m)."""
        return float(np.sqrt(np.trace(self.covariance, axis1=1, axis2=2).mean()))

    @property
    def nees(self) -> float:
        """Mean normalised position error squared; 3 for a consistent filter."""
        solved = np.linalg.solve(self.covariance, self.ekf_m[..., None])[..., 0]
        return float((self.ekf_m * solved).sum(axis=1).mean())


def rms_m(errors_m: FloatArray) -> float:
    """Return the root mean square length of errors (M, 3) (m)."""
    return float(np.sqrt(np.square(errors_m).sum(axis=1).mean()))


def packets_of(recording: Recording) -> dict[int, list[tuple[int, Report]]]:
    """
    Return the packets that arrived, by tick of arrival: index of the receiver, position and velocity.

    They are rounded as in the compact format, and the position is that of the sender's navigation. The
    velocity is the true one, so they equal the packets only if the navigation is exact.
    """
    handed_over = {(source, sequence): tick for tick, source, sequence in recording.sent.tolist()}
    arrived: dict[int, list[tuple[int, Report]]] = {}
    for tick, source, destination, sequence in recording.received.tolist():
        sent = handed_over[source, sequence]
        q = recording.attitude_quat_wxyz[sent, source - 1].tolist()
        nu = recording.velocity_body[sent, source - 1].tolist()
        velocity = body_to_ned((q[0], q[1], q[2], q[3]), (nu[0], nu[1], nu[2]))
        report = Report(
            source,
            float(recording.t_s[sent]),
            _rounded(recording.nav_position_ned_m[sent, source - 1].tolist(), _POSITION_STEP_M),
            _rounded(velocity, _VELOCITY_STEP_MPS),
            _ZERO,
            _ZERO,
        )
        arrived.setdefault(tick, []).append((destination - 1, report))
    return arrived


def _rounded(vector: Vec3, step: float) -> Vec3:
    x, y, z = (step * round(value / step) for value in vector)
    return (x, y, z)


def errors_of(run: Run, config: NeighbourConfig | None = None) -> Errors:
    """
    Return the errors of all neighbours of all vehicles, every half second, from the first packet on.

    With `config` the filters run again with these settings; without it the estimates of the flight are used.
    """
    recording = run.recording
    n = len(recording.vehicle_ids)
    tables = None if config is None else [NeighbourTable(config) for _ in range(n)]
    arrived, last = packets_of(recording), {}
    rows = []
    for tick in range(len(recording.t_s) - 1):
        for receiver, report in arrived.get(tick, ()):
            last[receiver, report.address - 1] = report
            if tables is not None:
                tables[receiver].receive(report)
        if tick % EVERY_TICKS == 0:
            estimated = _recorded(recording, tick) if tables is None else _repeated(tables, recording, tick)
            for (receiver, other), report in last.items():
                position, covariance = estimated[receiver, other]
                rows.append(_row(recording, tick, other, report, position, covariance))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return Errors(*columns)


Estimated = dict[tuple[int, int], tuple[FloatArray, FloatArray]]


def _recorded(recording: Recording, tick: int) -> Estimated:
    n = len(recording.vehicle_ids)
    return {
        (i, j): (
            recording.neighbour_position_ned_m[tick, i, j],
            recording.neighbour_covariance[tick, i, j, :3, :3],
        )
        for i in range(n)
        for j in range(n)
        if i != j
    }


def _repeated(tables: list[NeighbourTable], recording: Recording, tick: int) -> Estimated:
    t_s = float(recording.t_s[tick])
    return {
        (i, estimate.address - 1): (np.array(estimate.position), estimate.covariance[:3, :3])
        for i, table in enumerate(tables)
        for estimate in table.estimates(t_s)
    }


def _row(
    recording: Recording, tick: int, other: int, report: Report, position: FloatArray, covariance: FloatArray
) -> tuple[object, ...]:
    t_s, truth = recording.t_s[tick], recording.position_ned_m[tick, other]
    age_s = t_s - report.time_s
    held = np.array(report.position) - truth
    return t_s, age_s, position - truth, held, held + age_s * np.array(report.velocity), covariance


@dataclass(frozen=True)
class Relative:
    """
    Errors of relative positions: (estimate - own navigation) - (true difference).

    `t_s` (K,) (s); `errors_m` (K, N, N, 3) and `covariance` (K, N, N, 3, 3) (m, m^2; NED), NaN if there is
    no estimate.
    """

    t_s: FloatArray
    errors_m: FloatArray
    covariance: FloatArray

    def formed(self) -> tuple[FloatArray, FloatArray]:
        """Return errors (M, 3) and covariances (M, 3, 3) of the formed flock."""
        late = self.t_s >= FORMED_S
        errors_m, covariance = self.errors_m[late], self.covariance[late]
        known = np.isfinite(errors_m).all(axis=-1)
        return errors_m[known], covariance[known]

    def rms_over_time_m(self) -> FloatArray:
        """Return the root mean square error over all pairs at every instant (K,) (m)."""
        squares = np.square(self.errors_m).sum(axis=-1).reshape(len(self.t_s), -1)
        known = np.isfinite(squares)
        total = np.where(known, squares, 0.0).sum(axis=1)
        return np.asarray(np.sqrt(total / np.maximum(known.sum(axis=1), 1)))


def relative_errors(run: Run) -> Relative:
    """Return the relative errors of a run, every half second."""
    r = run.recording
    ticks = np.arange(0, len(r.t_s) - 1, EVERY_TICKS)
    errors_m = relative_position_error_ned_m(r, ticks)
    return Relative(r.t_s[ticks], errors_m, r.neighbour_covariance[ticks][..., :3, :3])
