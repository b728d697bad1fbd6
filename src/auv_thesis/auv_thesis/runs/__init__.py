"""The runs of the reproduction: flown once, kept, and reused by later calls."""
