"""Experiments: a scenario, its run in one process, what was recorded, metrics, reports and sweeps."""
