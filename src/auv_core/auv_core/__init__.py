"""
Definitions that all packages of Shoal share: geometry, vehicle models, messages between components, strict
loading. It has no simulator and no control law.
"""
