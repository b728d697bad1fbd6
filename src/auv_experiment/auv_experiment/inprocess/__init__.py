"""Runs in one process, without ROS: sampled as the nodes are, or in continuous time."""
