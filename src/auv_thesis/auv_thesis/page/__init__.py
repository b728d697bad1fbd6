"""The page of the reproduction, and the documents that are written from its items."""
