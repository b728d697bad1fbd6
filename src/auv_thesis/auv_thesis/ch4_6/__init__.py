"""Chapters 4 to 6: steering to a region, flocking with mathematical and with fuzzy potentials."""
