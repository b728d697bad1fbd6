"""
The water as a network: what happens to a packet between two modems.

Four plugin folders, one file per kind, named in a scenario as ``acoustics: {propagation: {kind, params},
modem: ..., mac: ..., outage: ...}``; ``acoustics.preset`` names a file of ``presets/`` that fills in the
sections left out.
"""
