"""The runs of the reproduction: flown once, kept, and taken from there the next time."""
