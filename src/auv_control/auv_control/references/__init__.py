"""
References: the path in space and time that a leader follows.

To add one, write one file with ``Params`` and ``Reference(params)`` with ``heading_rad``, ``period_s`` (time
of one round, or None), ``position(t_s)`` (m; NED) and ``velocity(t_s)`` (m/s; NED), its exact derivative.
The file's name is its ``kind``.
"""
