"""
Push-sum with running sums: an average that lost packets cannot bias.

Hadjicostis, Vaidya & Dominguez-Garcia, "Robust distributed average consensus via exchange of running sums",
IEEE TAC 61(6), 2016, after Kempe, Dobra & Gehrke (FOCS 2003); the inputs and what moves are ours.

A vehicle holds a mass, coordinates y (m) and weight z; it begins with its own position and weight 1.  With
every packet it gives an n-th of the mass to each of the other n - 1 vehicles, but keeps a weight of at least
`least_weight`.  The packet does not carry the gift but the sum of all gifts to one receiver so far; a
receiver takes the difference to the sum that it saw last, and so what lost packets brought comes with the
next one that arrives.  Mass is never lost nor made: sum y / sum z over vehicles and gifts on their way is the
mean of the inputs at any loss, and all y / z converge to it as long as every link delivers now and then (any
loss below 100 %).

* Inputs that change enter as increments.  They wait in a store r of their own, of which every packet gives an
  n-th to each too, and count in the own estimate with r / n, which is what the mean will feel.  Put into y,
  with a weight z far from 1 between packets, a vehicle's own motion would move its estimate by 1 / z.
* What is averaged is q = eta - p, where p is a frame that each vehicle carries on with the flock's velocity
  w (`follow_flock`) and draws towards the frames of the others, p_dot = w + k_f sum_j (p_j - p_i) / n; the
  estimate is y / z + r / n + p.  It settles at mean(eta) + p_i - mean(p): exact where frames agree, however
  they came to, and in a flock that moves as one q stands still.  Frames are drawn together stably with news
  of any age, since each moves to a weighted mean.  Without `follow_flock` p is zero, packets are shorter, and
  estimates lag by the mixing: metres, in a moving flock with losses.
* Gifts are rounded to the resolution of their fields (2^-12 m, 2^-20) and the rest stays with the giver; sums
  go modulo the fields' ranges.  Both are powers of two, so packets carry the sums exactly and, rounded or
  not, sum y and sum z are kept to floating-point accuracy.  What rounding costs is agreement: coordinates and
  weight of a gift are rounded each on its own, so an estimate can be wrong by a few times (2^-13 m + 2^-21
  |y / z|) / z; measured: 2 mm.  Without rounding (`quantise: false`, for reports of kind `exact`) errors go
  to zero.  Frames are sent to 2^-7 m; agreement of frames ends there.

Limits.  Differences of sums are taken as less than half a range: gifts missed in a row must stay under 2^16 m
and 32 in weight.  A gift is at most |y| / n: thousands of packets within 100 m of the origin, fifty at 5 km
and n = 4.  `fleet_size` must be the number of vehicles that hear: the share of one that never does piles
up on the way to it until all others are down to `least_weight`; then they give nothing more, and estimates
no longer mix.  A vehicle that starts anew in a running fleet takes old gifts again: a fleet starts together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field
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
    """Push-sum itself has little to choose."""

    least_weight: float = param(
        "weight that a vehicle keeps for itself, of 1 that it begins with",
        default=0.5,
        above=0.0,
        maximum=0.9,
    )
    follow_flock: bool = param("carry the frame of the average on with the flock's velocity", default=True)
    frame_rate_ps: float = param(
        "rate k_f at which the frames of the average are drawn together (1/s)", default=0.5, minimum=0.0
    )
    quantise: bool = param(
        "round what is given to what packets can carry; without it only exact reports keep the mean",
        default=True,
    )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs what packets say of the flock's velocity."""
        return self.follow_flock


def _wrapped(value: float, span: float) -> float:
    """Return `value` modulo `span`, nearest to zero."""
    return value - span * math.floor(value / span + 0.5)


class Consensus:
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

    @property
    def shared_fields(self) -> tuple[Field, ...]:
        """Sums of the gifts to one receiver; with `follow_flock` also the own frame."""
        half_m, half_frame_m = 0.5 * _LENGTH_RANGE_M, 0.5 * _FRAME_RANGE_M
        given = [Field(f"given_{a}_m", -half_m, half_m, _LENGTH_STEP_M, wraps=True) for a in _AXES]
        weight = Field("given_weight", -0.5 * _WEIGHT_RANGE, 0.5 * _WEIGHT_RANGE, _WEIGHT_STEP, wraps=True)
        frame = [Field(f"frame_{a}_m", -half_frame_m, half_frame_m, _FRAME_STEP_M, wraps=True) for a in _AXES]
        return (*given, weight, *(frame if self._params.follow_flock else ()))

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """Take what is new in packets and in the own position; return the estimate (m; NED)."""
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
        """Move the frame on; return the flock's velocity (m/s; NED), or zero where it is not looked at."""
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
        """Give: return the sums of all gifts to one receiver, this packet's included, and the own frame."""
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
        """Return the multiple of `step` nearest to an amount, or the amount where nothing is rounded."""
        return step * round(amount / step) if self._params.quantise else amount
