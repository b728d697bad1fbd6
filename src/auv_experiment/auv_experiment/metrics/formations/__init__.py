"""Metrics of formations: those of chapter 3, those of slots, and stability along a formation."""
