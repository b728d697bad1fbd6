"""Commands: `run`, `replay` and `topic`."""
