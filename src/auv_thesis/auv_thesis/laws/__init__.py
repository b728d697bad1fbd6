"""Comparisons of laws; each file is a chapter of the page."""
