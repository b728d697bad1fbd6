"""Scenarios: the schema, the files, the checks at load, and the built-in scenarios."""
