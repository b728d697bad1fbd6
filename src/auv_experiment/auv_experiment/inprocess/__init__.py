"""Runs in one process, without ROS: sampled like the nodes, or in continuous time."""
