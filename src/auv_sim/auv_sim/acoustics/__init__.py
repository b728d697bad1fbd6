"""
The acoustic network: transmission of packets between modems.

Five plugin folders, one file per kind, named in a scenario as ``acoustics: {propagation: {kind, params},
modem: ..., mac: ..., outage: ..., sonar: ...}``; ``acoustics.preset`` names a file of ``presets/`` that
fills in missing sections.

`medium` is the whole network, `receiver` the receiving part of one modem, `water` has the formulas, `links`
the counters, `event_log` the order of the acoustic log and a check of it, `talk` modems without vehicles.
"""
