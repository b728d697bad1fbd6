"""Benchmarks: costs of Shoal, each with a limit that is measured in the same run."""
