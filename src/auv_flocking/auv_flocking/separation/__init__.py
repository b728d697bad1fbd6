"""
Separation laws: what keeps two vehicles, or a vehicle and an obstacle, apart.

To add one, write one file with ``Params`` and ``Separation(params)`` with ``velocity(own, other, spacing_m)
-> Vec3``: the velocity (m/s; NED, for unit gain) that the law asks of the vehicle at `own` because of
`other`.  The file's name is its ``kind``.  A law may have besides

* ``obstacle_velocity(own, obstacle, spacing_m) -> Vec3``, where obstacles are not treated as vehicles are;
* ``potential(distance_m, spacing_m) -> float`` and ``obstacle_potential`` (m^2/s), of which the velocities
  are the falls: runs then say whether the flock's potential falls;
* ``adapt(distances_m, spacing_m, dt_s)``, where it has a memory: called once per control period with the
  distances to the neighbours.  ``Params`` says so with a property ``adapts``: such a law is refused in
  continuous time;
* ``strength`` and ``numbers``, of `auv_flocking.central`, where it acts along the line between the two: it is
  then compiled with the loop over all pairs of a flock, over near ones only where there is
  ``reach_m(spacing_m) -> float``, the distance from which on it is zero (m).  ``obstacle_strength`` and
  ``obstacle_numbers`` are those of `obstacle_velocity` where that is another law.
"""
