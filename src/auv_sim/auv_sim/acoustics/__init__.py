"""
The water as a network: what happens to a packet between two modems.

Five plugin folders, one file per kind, named in a scenario as ``acoustics: {propagation: {kind, params},
modem: ..., mac: ..., outage: ..., sonar: ...}``; ``acoustics.preset`` names a file of ``presets/`` that fills
in the sections left out.

`medium` is the whole, `receiver` one modem's ear, `water` the formulas, `links` the counters, `event_log` the
order of the acoustic log and what must not be in it, `talk` modems without vehicles.
"""
