"""
Separation laws: what keeps two vehicles, or a vehicle and an obstacle, apart.

To add one, write one file with ``Params`` and ``Separation(params)`` with ``velocity(own, other, spacing_m)
-> Vec3``: the velocity (m/s; NED, for unit gain) that the law asks of the vehicle at `own` because of
`other`.  The file's name is its ``kind``.
"""
