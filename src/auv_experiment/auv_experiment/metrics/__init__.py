"""Numbers that say how a run went, all from its recording."""
