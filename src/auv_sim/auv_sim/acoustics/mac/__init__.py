"""
Medium access: when a modem may transmit.

To add one, write one file with ``Params`` and ``Mac(params, fleet_size)`` with
``opportunity_s(address, tick, period_s) -> float | None``: the start (s) of the first transmission that this
modem may begin in the control period [tick, tick + 1), or None; and ``check(airtime_s)``, which raises
ValueError (message ``field: ...``) when a transmission of that length does not fit the scheme.
"""
