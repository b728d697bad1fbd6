"""Figures of a run, all from its recording."""
