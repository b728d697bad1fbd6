"""
Shared vocabulary of Shoal: geometry, vehicle models, messages between components, strict loading; no
simulator, no law.
"""
