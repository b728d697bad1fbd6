"""Bags: rosbag2 in MCAP, written in a process of its own, read, compared and mended. No ROS at import."""
