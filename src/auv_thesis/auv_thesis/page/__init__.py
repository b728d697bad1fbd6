"""The page of the reproduction, and the documents generated from its items."""
