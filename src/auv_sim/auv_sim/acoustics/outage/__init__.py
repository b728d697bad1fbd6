"""
Outage: losses that no model of range or noise explains.

To add one, write one file with ``Params`` and ``Outage(params, seed)`` with
``lost(source, destination, sequence) -> bool``.  The answer may depend on nothing else than the seed and
these three, so that adding a vehicle does not change the others' luck; `auv_sim.streams.uniform`
gives the numbers.
"""
