"""The thesis, redone: its figures, tables and claims, from runs of ours."""
