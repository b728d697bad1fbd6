"""
Consensus filters: how a vehicle estimates the flocking centre from its own position and what its neighbours
say.

To add one, write one file with ``Params`` and ``Consensus(params, fleet_size)`` with

* ``shared_fields: tuple[Field, ...]``: what it adds to every packet beside the centre and its rate, `()` for
  nothing; see `auv_flocking.codec.Field`;
* ``centre(own, heard) -> Vec3``: the estimate at this control period (m; NED), from the own position and the
  estimates of the neighbours that count; called once per period, first;
* ``advance(own, heard, flock_velocity, dt_s) -> Vec3``: called once per period, after `centre`, with the
  flock's velocity as the vehicle believes it now: move the memory on by one period, and return the rate (m/s;
  NED) with which the others may carry the estimate on until they hear more;
* ``shared() -> tuple[float, ...]``: the numbers for the shared fields; called after `advance`, only in a
  period in which a packet is handed to the modem.

A filter that can run in continuous time has, besides, ``derivative(own, centre, neighbour_centres,
flock_velocity) -> Vec3``, the rate of an estimate that the caller keeps, and ``reach_m``, the distance from
which on it hears no neighbour (m; inf for none).  Where a filter looks at the flock's
velocity, ``Params`` says so with a property ``uses_flock_velocity``: packets carry it, so such a filter is
refused in continuous time.  The file's name is its ``kind``.
"""

from __future__ import annotations

from collections.abc import Sequence

from auv_core.geometry import Vec3, distance


def centres_within(reach_m: float, own: Vec3, others: Sequence[tuple[Vec3, Vec3]]) -> list[Vec3]:
    """Return the estimates of the others within `reach_m` (m); others are (position, estimate) (m; NED)."""
    return [centre for position, centre in others if distance(own, position) < reach_m]
