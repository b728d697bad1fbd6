"""Processes of nodes: which, how they are started, watched and ended."""
