"""Acoustic communication: medium, medium access, estimation, consensus, safety."""
