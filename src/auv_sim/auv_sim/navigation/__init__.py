"""
Navigation: what a vehicle believes of its own motion.

To add one, write one file with ``Params`` and ``Navigation(params, seed, address, period_s)`` with
``measured(state) -> VehicleState``: what the vehicle's own navigation says when the truth is `state`, once
per control period, with the standard deviations that it believes of itself, and with ``is_valid`` false
where it has no solution.  It may look at the truth of this tick and remember what came before, nothing else;
randomness comes from `auv_sim.streams`.  The file's name is its ``kind``.

People and tools also see, on ``odom`` and ``/tf``: ``odom_frame`` (an `auv_core.odom_frame.OdomFrame` that
takes up the jumps of the estimate), ``depth_sd_m``, and ``velocity_sd_mps`` along the body's three axes.
"""
