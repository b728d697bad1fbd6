"""
Consensus filters: they estimate the flocking centre from the own position and the neighbours' packets.

To add one, write one file with ``Params``, which are `ConsensusParams`, and ``Consensus(params,
fleet_size)``, a `ConsensusFilter`, or a `ContinuousFilter` if it can run in continuous time.  The file's
name is its ``kind``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3, distance
from auv_core.params import Section
from auv_flocking.codec import Field
from auv_flocking.neighbours.estimates import NeighbourEstimate, Neighbours


class ConsensusParams(Protocol):
    """Properties of a filter for the checks of a scenario."""

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether it uses the flock's velocity, which needs packets."""


class ConsensusFilter(Protocol):
    """
    The filter of one vehicle.

    `shared_fields`: fields that it adds to every packet besides the centre, `()` for none. The centre of a
    neighbour estimate is that of the time tag: a filter extrapolates it with `carried_centre`.
    """

    shared_fields: tuple[Field, ...]

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """
        Return the estimate at this control period (m; NED); called first, once per period.

        It follows from the own position (m; NED) and the estimates of the neighbours that count.
        """

    def advance(self, own: Vec3, heard: Neighbours, flock_velocity: Vec3, dt_s: float) -> Vec3:
        """
        Update the state by one period of `dt_s`; called once per period, after `centre`.

        Returns the rate (m/s; NED) with which others extrapolate the estimate until the next packet: the
        flock's velocity, zero, or a rate that the filter shares.
        `flock_velocity` is this vehicle's estimate (m/s; NED).
        """

    def shared(self) -> tuple[float, ...]:
        """Return the numbers for the shared fields; called after `advance` if a packet is sent."""


@runtime_checkable
class ContinuousFilter(ConsensusFilter, Protocol):
    """
    A filter whose estimate the caller can keep; `reach_m`: range within which it hears others (m; inf: all).
    """

    reach_m: float

    def derivative(
        self, own: Vec3, centre: Vec3, neighbour_centres: Sequence[Vec3], flock_velocity: Vec3
    ) -> Vec3:
        """Return the rate of the estimate `centre` (m/s; NED), for a position and estimates (m; NED)."""


def make_consensus(section: Section, fleet_size: int) -> ConsensusFilter:
    """Return the filter of a section for a vehicle of a fleet."""
    made = class_of(__name__, section.kind, "Consensus")(section.params, fleet_size)
    item: ConsensusFilter = fulfilled(made, ConsensusFilter)
    return item


def consensus_params(section: Section) -> ConsensusParams:
    """Return the parameters of a section, typed as those of every filter."""
    params: ConsensusParams = fulfilled(section.params, ConsensusParams)
    return params


def carried_centre(other: NeighbourEstimate, rate: Vec3) -> Vec3:
    """Return a neighbour's estimate of the centre (m; NED), extrapolated with a rate (m/s; NED)."""
    (x, y, z), age_s = other.centre, other.age_s
    return (x + age_s * rate[0], y + age_s * rate[1], z + age_s * rate[2])


def centres_within(reach_m: float, own: Vec3, others: Sequence[tuple[Vec3, Vec3]]) -> list[Vec3]:
    """Return the estimates of the others within `reach_m` (m); others are (position, estimate) (m; NED)."""
    return [centre for position, centre in others if distance(own, position) < reach_m]
