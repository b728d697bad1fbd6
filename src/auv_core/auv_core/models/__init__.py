"""
Vehicle models: the equations of motion.  One file per structure; the numbers are in ``presets/*.yaml``.

To add a model with new equations, write one file here with

1. ``Params``: a frozen dataclass made of `auv_core.params.param` fields, with at least ``hull_radius_m``;
2. ``Model(params)`` with ``command`` (``'wrench'`` or ``'velocity'``), ``initial_state(position,
   heading_rad)``, ``limited_command(command)`` (what the actuators make of a command), ``top_speed_mps``,
   ``speed_held_mps(max_force_n)`` and
   ``step(state, command, current, dt_s, steps)`` (so many steps of dt_s with the command as the actuators
   give it, held), on the 13 floats of a state: NED position (m), attitude quaternion body to NED (w, x, y,
   z), nu (m/s, rad/s; body FRD);
3. for a model that takes a wrench also ``derivative(state, command, current)`` and ``normalised(state)``, of
   which continuous-time runs make their own integration, and ``kinetic_energy(nu)`` (J).

The file's name is its ``kind``.  To add a vehicle with new numbers, write one file ``presets/<name>.yaml``
with ``kind`` and ``params``.  The conformance tests check every model and preset found: finite,
deterministic, inputs not changed.
"""
