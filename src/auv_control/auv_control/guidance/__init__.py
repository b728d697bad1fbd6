"""
Guidance of vehicles with propeller and fins: autopilots, paths of lines and arcs, line of sight.

Everything is a pure step: state and inputs come in as NamedTuples of floats, a new state and the outputs go
out. Angles are in rad, headings and courses from north towards east, positions in NED (m).
"""
