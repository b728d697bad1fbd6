"""Metrics of vehicles that follow a course, alone and as a fleet."""
