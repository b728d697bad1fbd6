"""
The neighbour estimates at one instant: a row of numbers for each neighbour, which laws read.

A track changes with a measurement, its estimate at every tick. Therefore one row per track (its source) has
the data for the estimate, and `carried_to` computes all rows of an instant from all sources in one call.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inner
from auv_core.geometry import Vec3
from auv_flocking.neighbours.motion import Turning, carried, grown

Matrix = NDArray[np.float64]

#  Columns of an estimate; for vectors and the covariance (36 numbers) the first column. The first PUBLISHED
# columns are those of auv_msgs/NeighbourEstimate, in its order.
POSITION, VELOCITY, COVARIANCE, AGE, SONAR_AGE, CENTRE, FLOCK_VELOCITY = 0, 3, 6, 42, 43, 44, 47
FLOCK_STAMP, FLOCK_TURN_RATE, HEADING, NAVIGATION_SD, TIME = 50, 51, 52, 53, 54
HOLDS, HEARD_WITHIN, HEARD_MASK = 55, 56, 57
WIDTH = 58
PUBLISHED = CENTRE

# Columns of a source: the state (10) and its covariance (36) at a time, and the newest report.
_STATE, _STATE_COVARIANCE, _STATE_TIME, _PSD, _DRIFTS, _TOWARDS = 0, 10, 46, 47, 48, 49
_REPORT_TIME, _REPORT_CENTRE, _REPORT_FLOCK, _REPORT_STAMP, _REPORT_TURN_RATE = 53, 54, 57, 60, 61
_REPORT_HEADING, _REPORT_SD, _REPORT_HOLDS, _REPORT_WITHIN, _REPORT_MASK, _SEEN = 62, 63, 64, 65, 66, 67
SOURCE_WIDTH = 68
REPORTED = _SEEN - _REPORT_TIME


class NeighbourEstimate(NamedTuple):
    """
    The estimate of a neighbour at one instant.

    position (m), velocity (m/s), centre (m), flock_velocity (m/s): NED, in the frame of the own navigation;
    covariance (6, 6) of position relative to the own vehicle, and of velocity; age_s: time since the time tag
    `time_s` of its newest packet. centre, flock_velocity, heading_rad (from north to east; NaN: unknown): as
    in that packet. flock_stamp_s: time at which a leader set this flock velocity (-inf: never received);
    since then it turns at flock_turn_rate_radps; sonar_age_s: time since the own sonar saw it (inf: never);
    navigation_sd_m: standard deviation of the neighbour's own navigation, per axis, as it states (the
    covariance includes it); shared: numbers that its consensus filter added to the packet. is_holding: at the
    time tag it held station; heard_within_s, heard_mask: whom it had heard by then, see `auv_flocking.heard`.
    """

    address: int
    position: Vec3
    velocity: Vec3
    covariance: Matrix
    age_s: float
    centre: Vec3
    flock_velocity: Vec3
    flock_stamp_s: float = -math.inf
    sonar_age_s: float = math.inf
    navigation_sd_m: float = 0.0
    time_s: float = -math.inf
    shared: tuple[float, ...] = ()
    flock_turn_rate_radps: float = 0.0
    heading_rad: float = math.nan
    is_holding: bool = False
    heard_within_s: float = 1.0
    heard_mask: int = 0


Neighbours = Sequence[NeighbourEstimate]


class Estimates(Sequence[NeighbourEstimate]):
    """
    The neighbours of one vehicle at one instant, in the order of addresses.

    Attributes
    ----------
    addresses : list of int
        Acoustic addresses.
    rows : (n, WIDTH) array
        Their numbers, in the columns of this module.
    shared : list of tuple
        Numbers that their consensus filters added to their packets.
    who : (n,) array of int
        The addresses as an array.

    """

    def __init__(
        self,
        addresses: list[int],
        rows: Matrix,
        shared: list[tuple[float, ...]],
        who: NDArray[np.int64] | None = None,
    ) -> None:
        self.addresses, self.rows, self.shared = addresses, rows, shared
        self.who = np.array(addresses, dtype=np.int64) if who is None else who
        self._items: list[NeighbourEstimate] | None = None
        self._positions: tuple[Vec3, ...] | None = None

    @classmethod
    def of(cls, estimates: Sequence[NeighbourEstimate]) -> Estimates:
        """Return estimates as rows; rows are returned unchanged."""
        if isinstance(estimates, cls):
            return estimates
        rows = [
            (
                *e.position, *e.velocity, *e.covariance.ravel(), e.age_s, e.sonar_age_s, *e.centre,
                *e.flock_velocity, e.flock_stamp_s, e.flock_turn_rate_radps, e.heading_rad,
                e.navigation_sd_m, e.time_s, e.is_holding, e.heard_within_s, e.heard_mask,
            )
            for e in estimates
        ]  # fmt: skip
        numbers = np.array(rows, dtype=np.float64).reshape(-1, WIDTH)
        return cls([e.address for e in estimates], numbers, [e.shared for e in estimates])

    def __len__(self) -> int:
        return len(self.addresses)

    def __iter__(self) -> Iterator[NeighbourEstimate]:
        return iter(self._objects())

    @overload
    def __getitem__(self, index: int) -> NeighbourEstimate: ...

    @overload
    def __getitem__(self, index: slice) -> list[NeighbourEstimate]: ...

    def __getitem__(self, index: int | slice) -> NeighbourEstimate | list[NeighbourEstimate]:
        return self._objects()[index]

    def column(self, index: int) -> list[float]:
        """Return one number of every neighbour."""
        numbers: list[float] = self.rows[:, index].tolist()
        return numbers

    def positions(self) -> tuple[Vec3, ...]:
        """Return their positions (m; NED)."""
        if self._positions is None:
            self._positions = tuple([(x, y, z) for x, y, z in self.rows[:, :3].tolist()])
        return self._positions

    def _objects(self) -> list[NeighbourEstimate]:
        if self._items is None:
            self._items = [
                _object(address, row, shared)
                for address, row, shared in zip(self.addresses, self.rows, self.shared, strict=True)
            ]
        return self._items


def _object(address: int, row: Matrix, shared: tuple[float, ...]) -> NeighbourEstimate:
    x: list[float] = row.tolist()
    return NeighbourEstimate(
        address,
        (x[0], x[1], x[2]),
        (x[3], x[4], x[5]),
        row[COVARIANCE:AGE].reshape(6, 6),
        x[AGE],
        (x[CENTRE], x[CENTRE + 1], x[CENTRE + 2]),
        (x[FLOCK_VELOCITY], x[FLOCK_VELOCITY + 1], x[FLOCK_VELOCITY + 2]),
        x[FLOCK_STAMP],
        x[SONAR_AGE],
        x[NAVIGATION_SD],
        x[TIME],
        shared,
        x[FLOCK_TURN_RATE],
        x[HEADING],
        x[HOLDS] > 0.0,
        x[HEARD_WITHIN],
        int(x[HEARD_MASK]),
    )


class Positions(Sequence[Vec3]):
    """Positions of the neighbours at an instant (m; NED), computed at first use."""

    def __init__(self, estimates: Estimates) -> None:
        self._estimates = estimates

    def __len__(self) -> int:
        return len(self._estimates)

    def __iter__(self) -> Iterator[Vec3]:
        return iter(self._estimates.positions())

    @overload
    def __getitem__(self, index: int) -> Vec3: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Vec3, ...]: ...

    def __getitem__(self, index: int | slice) -> Vec3 | tuple[Vec3, ...]:
        return self._estimates.positions()[index]


def position_rows(heard: Neighbours) -> Matrix:
    """Return rows that begin with the neighbours' positions (m; NED)."""
    if isinstance(heard, Estimates):
        return heard.rows
    return np.array([other.position for other in heard], dtype=np.float64).reshape(-1, 3)


@entry("float64(float64[:, ::1])", allocates=False)
def heading_nearest_leader_rad(rows: Matrix) -> float:
    """
    Return the heading of the neighbour nearest to a leader in the chain of packets (rad; NaN: none).

    It has the newest flock velocity; of equals the one that sent it first, and so had it from no other. A
    neighbour without a leader's flock velocity, or whose report has no heading, does not count.
    """
    heading_rad, newest_s, sent_s = math.nan, -math.inf, math.inf
    for k in range(len(rows)):
        stamp_s, time_s = float(rows[k, FLOCK_STAMP]), float(rows[k, TIME])
        if math.isnan(rows[k, HEADING]) or stamp_s == -math.inf:
            continue
        if stamp_s > newest_s or (stamp_s == newest_s and time_s < sent_s):
            heading_rad, newest_s, sent_s = float(rows[k, HEADING]), stamp_s, time_s
    return heading_rad


@entry(
    "void(float64[::1], float64, float64[::1], float64[:, ::1], float64, TUPLE4, TUPLE14, float64)",
    allocates=False,
)
def write_source(
    source: Matrix,
    time_s: float,
    state: Matrix,
    covariance: Matrix,
    psd: float,
    towards: Turning,
    report: tuple[float, ...],
    seen_s: float,
) -> None:
    """
    Write the estimate of a track into its source row.

    Parameters
    ----------
    source : (SOURCE_WIDTH,) array
        The row.
    time_s : float
        Time of the estimate (s).
    state, covariance : (6,) or (10,), (6, 6) or (10, 10) array
        The estimate; see `filter.Belief`.
    psd : float
        Spectral density of the neighbour's acceleration (m^2/s^3).
    towards : (4,) tuple
        Velocity to which its own relaxes (m/s; NED), and its rate of turn (rad/s).
    report : (REPORTED,) tuple
        Data of its newest packet: time tag, centre, flock velocity, its stamp and turn rate, heading, stated
        deviation, whether it holds station, age class (s) and mask of what it has heard.
    seen_s : float
        Time of the newest sonar contact (s).

    """
    for k in range(10):
        source[k] = state[k] if k < len(state) else 0.0
    for i in range(6):
        for j in range(6):
            source[_STATE_COVARIANCE + 6 * i + j] = covariance[i, j]
    source[_STATE_TIME], source[_PSD], source[_SEEN] = time_s, psd, seen_s
    source[_DRIFTS] = 1.0 if len(state) > 6 else 0.0
    for k in range(4):
        source[_TOWARDS + k] = towards[k]
    for k in range(REPORTED):
        source[_REPORT_TIME + k] = report[k]


@entry("int64(float64, float64, float64, float64[:, ::1], float64[:, ::1], int64[::1])", allocates=False)
def carried_to(
    t_s: float, memory_s: float, timeout_s: float, sources: Matrix, rows: Matrix, who: NDArray[np.int64]
) -> int:
    """
    Extrapolate tracks to `t_s`: write the rows of those heard or seen within `timeout_s`; return their
    number.

    Parameters
    ----------
    t_s, memory_s, timeout_s : float
        Time, relaxation time of a velocity to the flock's (0: never), and the silence that ends a track (s).
    sources : (n, SOURCE_WIDTH) array
        The source rows.
    rows : (n, WIDTH) array
        Output, from the first row on.
    who : (n,) array
        Output: the source of each row.

    """
    count = 0
    for k in range(len(sources)):
        source = sources[k]
        if t_s - max(source[_REPORT_TIME], source[_SEEN]) <= timeout_s:
            _carry(t_s, memory_s, source, rows[count])
            who[count] = k
            count += 1
    return count


@inner
def _carry(t_s: float, memory_s: float, source: Matrix, row: Matrix) -> None:
    dt_s = max(t_s - float(source[_STATE_TIME]), 0.0)
    age_s = max(t_s - float(source[_REPORT_TIME]), 0.0)
    towards = (
        float(source[_TOWARDS]),
        float(source[_TOWARDS + 1]),
        float(source[_TOWARDS + 2]),
        float(source[_TOWARDS + 3]),
    )
    position, velocity = carried(source, dt_s, memory_s, towards)
    for axis in range(3):
        row[POSITION + axis] = position[axis]
        row[VELOCITY + axis] = velocity[axis]
        row[CENTRE + axis] = source[_REPORT_CENTRE + axis]
        row[FLOCK_VELOCITY + axis] = source[_REPORT_FLOCK + axis]
    if source[_DRIFTS] > 0.0:  # from the sender's frame to the own one
        for axis in range(2):
            row[CENTRE + axis] -= source[_STATE + 6 + axis] + dt_s * source[_STATE + 8 + axis]
    grown(source[_STATE_COVARIANCE:_STATE_TIME], dt_s, float(source[_PSD]), memory_s, row[COVARIANCE:AGE])
    row[AGE] = age_s
    row[FLOCK_STAMP] = source[_REPORT_STAMP]
    row[FLOCK_TURN_RATE] = source[_REPORT_TURN_RATE]
    row[HEADING] = source[_REPORT_HEADING]
    row[SONAR_AGE] = t_s - source[_SEEN]
    row[NAVIGATION_SD] = source[_REPORT_SD]
    row[TIME] = source[_REPORT_TIME]
    row[HOLDS] = source[_REPORT_HOLDS]
    row[HEARD_WITHIN] = source[_REPORT_WITHIN]
    row[HEARD_MASK] = source[_REPORT_MASK]
