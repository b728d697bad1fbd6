"""Experiments: scenarios, runs in one process, recordings, metrics, reports and sweeps."""
