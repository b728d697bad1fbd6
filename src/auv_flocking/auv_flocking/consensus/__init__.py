"""
Consensus filters: how a vehicle estimates the flocking centre from its own position and what its neighbours
say.

To add one, write one file with ``Params`` and ``Consensus(params)`` with

* ``derivative(own, centre, neighbour_centres, flock_velocity) -> Vec3``: the rate (m/s; NED) of the estimate
  `centre`, and
* ``step(own, centre, neighbour_centres, flock_velocity, dt_s) -> Vec3``: the estimate `dt_s` later, the
  inputs held.

Where they look at the flock's velocity, ``Params`` says so with a property ``uses_flock_velocity``: packets
carry it, so such a filter is refused in continuous time.  The file's name is its ``kind``.
"""
