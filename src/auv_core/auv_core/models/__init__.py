"""
Vehicle models: the equations of motion.  One file per structure; the numbers are in ``presets/*.yaml``.

To add a model with new equations, write one file here with

1. ``Params``: a frozen dataclass made of `auv_core.params.param` fields, with at least ``hull_radius_m``;
2. ``Model(params)`` with ``command`` (``'wrench'`` or ``'velocity'``), ``initial_state(position,
   heading_rad)``, ``limited_command(command)`` (what the actuators make of a command) and ``step(state,
   command, current, dt_s)`` (the command as the actuators give it, held), on the 13 floats of a state: NED
   position (m), attitude quaternion body to NED (w, x, y, z), nu (m/s, rad/s; body FRD).

The file's name is its ``kind``.  To add a vehicle with new numbers, write one file ``presets/<name>.yaml``
with ``kind`` and ``params``.  The conformance tests check every model and preset found: finite,
deterministic, inputs not changed.
"""
