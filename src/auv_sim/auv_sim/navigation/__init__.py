"""
Navigation: what a vehicle believes of its own motion.

To add one, write one file with ``Params`` and ``Navigation(params, seed, address)`` with ``measured(state) ->
VehicleState``: what the vehicle's own navigation says when the truth is `state`, with ``is_valid`` false
where it has no solution.  It may look at the truth of this tick and remember its own past, nothing else;
randomness comes from `auv_sim.streams`.  The file's name is its ``kind``.
"""
