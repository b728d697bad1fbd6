"""
The simulator: the true vehicle, its actuators, the current, and the acoustic medium between vehicles.
"""
