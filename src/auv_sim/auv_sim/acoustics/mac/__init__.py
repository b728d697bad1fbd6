"""
Medium access: when a modem asks its vehicle for data, and when it puts them on the air.

To add one, write one file with ``Params`` and ``Mac(params, fleet_size, seed)`` with

* ``opportunity_s(address, tick, period_s) -> float | None``: the first time (s) in the control period [tick,
  tick + 1) at which this modem would begin a transmission, or None; the same answer whenever it is asked;
* ``check(airtime_s)``, which raises ValueError (message ``field: ...``) when a transmission of that length
  does not fit the scheme;
* ``senses: bool``: whether the modem listens at that time and, while it hears anything, waits for
  ``backoff_s(source, sequence, attempt) -> float`` (s, above zero) and listens again, with the same packet.

A modem that is on the air, or holds a packet, does not ask.  Random numbers come from `auv_sim.streams` and
depend on nothing but the seed, the address, and the slot or packet.
"""
