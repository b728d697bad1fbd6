"""What one vehicle's computer does alone: references, control laws, avoidance, estimators."""
