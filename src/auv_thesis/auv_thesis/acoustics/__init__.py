"""The water between the vehicles: medium, medium access, estimation, consensus, safety."""
