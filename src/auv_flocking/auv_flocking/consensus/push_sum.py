"""
Push-sum with running sums: lost packets do not bias the average.

Hadjicostis, Vaidya & Dominguez-Garcia, "Robust distributed average consensus via exchange of running sums",
IEEE TAC 61(6), 2016, after Kempe, Dobra & Gehrke (FOCS 2003); changing inputs and motion are our extension.

A vehicle has a mass, that is coordinates y (m) and a weight z; it starts with its own position and weight 1.
With every packet it gives 1/n of the mass to each of the other n - 1 vehicles, but keeps a weight of at least
`least_weight`. The packet does not carry this share but the running sum of all shares to one receiver. A
receiver takes the difference to the last sum that it received, so the shares of lost packets arrive with the
next packet. Mass is neither lost nor created: sum y / sum z over vehicles and shares in transit is the mean
of the inputs at any loss, and all y / z converge to it as long as every link delivers packets from time to
time (any loss below 100 %).

* Changing inputs enter as increments. They are collected in a separate store r, of which every packet also
  gives 1/n to each receiver, and count in the own estimate with r / n, their later effect on the mean. If
  they were added to y, whose weight z may be far from 1 between packets, a vehicle's own motion would move
  its estimate by 1 / z.
* The averaged quantity is q = eta - p, where p is a frame that each vehicle moves with the flock's velocity
  w (`follow_flock`) and towards the frames of the others, p_dot = w + k_f sum_j (p_j - p_i) / n; the estimate
  is y / z + r / n + p. It settles at mean(eta) + p_i - mean(p), which is exact if the frames agree. In a
  flock that moves as one body q is constant. The frames converge stably with data of any age, since each
  moves to a weighted mean. Without `follow_flock` p is zero, packets are shorter, and estimates lag by the
  mixing time: by metres in a moving flock with losses.
* Shares are rounded to the resolution of their fields (2^-12 m, 2^-20), and the remainder stays with the
  sender; sums are taken modulo the fields' ranges. Both are powers of two, so packets carry the sums exactly,
  and sum y and sum z are kept to floating-point accuracy. Rounding limits the agreement: coordinates and
  weight of a share are rounded separately, so an estimate can be wrong by a few times (2^-13 m + 2^-21 |y /
  z|) / z; measured: 2 mm. Without rounding (`quantise: false`, for reports of kind `exact`) errors go to
  zero. Frames are sent with a resolution of 2^-7 m, which limits their agreement.

Limits. Differences of sums are assumed to be less than half a range: the shares of consecutive lost packets
must stay below 2^16 m and 32 in weight. A share is at most |y| / n: this allows thousands of packets within
100 m of the origin, and fifty at 5 km with n = 4. `fleet_size` must be the number of vehicles that receive:
the shares of a vehicle that never does accumulate until all others are down to `least_weight`; then they give
no more, and estimates no longer mix. A vehicle that restarts in a running fleet takes old shares again, so a
fleet must start together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field
from auv_flocking.consensus import ConsensusFilter
from auv_flocking.neighbours.estimates import NeighbourEstimate, Neighbours

_LENGTH_RANGE_M = 2.0**17
_LENGTH_STEP_M = 2.0**-12
_WEIGHT_RANGE = 64.0
_WEIGHT_STEP = 2.0**-20
_FRAME_RANGE_M = 2.0**10
_FRAME_STEP_M = 2.0**-7
_RANGES = (_LENGTH_RANGE_M, _LENGTH_RANGE_M, _LENGTH_RANGE_M, _WEIGHT_RANGE)
_AXES = ("north", "east", "down")


@dataclass(frozen=True)
class Params:
    """Parameters of push-sum."""

    least_weight: float = param(
        "weight that a vehicle always keeps, of its initial weight 1",
        default=0.5,
        above=0.0,
        maximum=0.9,
    )
    follow_flock: bool = param(
        "whether to move the frame of the average with the flock's velocity", default=True
    )
    frame_rate_ps: float = param(
        "rate k_f at which the frames of the average converge (1/s)", default=0.5, minimum=0.0
    )
    quantise: bool = param(
        "whether to round shares to the resolution of packets; without it only exact reports keep the mean",
        default=True,
    )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs the flock's velocity from packets."""
        return self.follow_flock


def _wrapped(value: float, span: float) -> float:
    """Return `value` modulo `span`, nearest to zero."""
    return value - span * math.floor(value / span + 0.5)


def _shared_fields(*, with_frame: bool) -> tuple[Field, ...]:
    """Return the running sums of the shares to one receiver, and the own frame if that is sent, too."""
    half_m, half_frame_m = 0.5 * _LENGTH_RANGE_M, 0.5 * _FRAME_RANGE_M
    given = [Field(f"given_{a}_m", -half_m, half_m, _LENGTH_STEP_M, wraps=True) for a in _AXES]
    weight = Field("given_weight", -0.5 * _WEIGHT_RANGE, 0.5 * _WEIGHT_RANGE, _WEIGHT_STEP, wraps=True)
    frame = [Field(f"frame_{a}_m", -half_frame_m, half_frame_m, _FRAME_STEP_M, wraps=True) for a in _AXES]
    return (*given, weight, *(frame if with_frame else ()))


class Consensus(ConsensusFilter):
    """One vehicle's filter; it starts at the own position."""

    def __init__(self, params: Params, fleet_size: int) -> None:
        self._params = params
        self._fleet_size = fleet_size
        self._mass = [0.0, 0.0, 0.0, 1.0]
        self._store = [0.0, 0.0, 0.0]
        self._frame = [0.0, 0.0, 0.0]
        self._frame_at_tag: tuple[float, ...] = (0.0, 0.0, 0.0)
        self._input: list[float] | None = None
        self._given = [0.0, 0.0, 0.0, 0.0]
        self._taken: dict[int, tuple[float, tuple[float, ...]]] = {}
        self.shared_fields = _shared_fields(with_frame=params.follow_flock)

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """Take new shares from packets and the change of the own position; return the estimate (m; NED)."""
        inputs = [own[axis] - self._frame[axis] for axis in range(3)]
        if self._input is None:
            self._mass[:3] = inputs
        else:
            for axis in range(3):
                self._store[axis] += inputs[axis] - self._input[axis]
        self._input = inputs
        for other in heard:
            self._take(other)
        return self._estimate()

    def _take(self, other: NeighbourEstimate) -> None:
        time_s, before = self._taken.get(other.address, (-math.inf, (0.0, 0.0, 0.0, 0.0)))
        if other.time_s <= time_s:
            return
        for index, span in enumerate(_RANGES):
            self._mass[index] += _wrapped(other.shared[index] - before[index], span)
        self._taken[other.address] = (other.time_s, other.shared)

    def _estimate(self) -> Vec3:
        mass, store, frame, count = self._mass, self._store, self._frame, self._fleet_size
        weight = mass[3]
        return (
            mass[0] / weight + store[0] / count + frame[0],
            mass[1] / weight + store[1] / count + frame[1],
            mass[2] / weight + store[2] / count + frame[2],
        )

    def advance(self, own: Vec3, heard: Neighbours, flock_velocity: Vec3, dt_s: float) -> Vec3:
        """Update the frame; return the flock's velocity (m/s; NED), or zero if it is not used."""
        if not self._params.follow_flock:
            return (0.0, 0.0, 0.0)
        self._frame_at_tag = tuple(self._frame)
        pull = -math.expm1(-self._params.frame_rate_ps * dt_s) / self._fleet_size
        for axis in range(3):
            frame_m = self._frame[axis]
            ahead_m = 0.0
            for other in heard:
                carried_m = other.shared[4 + axis] + other.age_s * other.flock_velocity[axis]
                ahead_m += _wrapped(carried_m - frame_m, _FRAME_RANGE_M)
            self._frame[axis] = frame_m + flock_velocity[axis] * dt_s + pull * ahead_m
        return flock_velocity

    def shared(self) -> tuple[float, ...]:
        """
        Give shares: return the running sums to one receiver, including this packet's share, and the own
        frame.
        """
        mass, others = self._mass, self._fleet_size - 1
        weight = mass[3]
        spare = max(0.0, weight - self._params.least_weight)
        gift = self._rounded(min(weight / self._fleet_size, spare / others if others else 0.0), _WEIGHT_STEP)
        for axis in range(3):
            of_mass_m = self._rounded(mass[axis] * (gift / weight), _LENGTH_STEP_M)
            of_store_m = self._rounded(self._store[axis] / self._fleet_size, _LENGTH_STEP_M)
            mass[axis] -= others * of_mass_m
            self._store[axis] -= others * of_store_m
            self._given[axis] = _wrapped(self._given[axis] + of_mass_m + of_store_m, _LENGTH_RANGE_M)
        mass[3] = weight - others * gift
        self._given[3] = _wrapped(self._given[3] + gift, _WEIGHT_RANGE)
        return (*self._given, *(self._frame_at_tag if self._params.follow_flock else ()))

    def _rounded(self, amount: float, step: float) -> float:
        """Return the multiple of `step` nearest to an amount, or the amount itself without rounding."""
        return step * round(amount / step) if self._params.quantise else amount
