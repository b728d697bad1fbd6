"""
Sonar: what a vehicle sees of other hulls by itself, with no packet.

To add one, write one file with ``Params`` and ``Sonar(params, seed)`` with ``contacts(address, tick,
period_s, states) -> tuple[SonarContact, ...]``: what the vehicle with this address sees when the fleet is in
`states` (the truth, in the order of addresses), and () in a tick without a ping.  A contact has no
identity, so neither may the order of contacts betray one.  Randomness comes from `auv_sim.streams` by
observer, target and tick, so that another vehicle does not change anybody's luck.  The file's name is its
``kind``.
"""
