"""Bags: rosbag2 in MCAP. Written in a separate process, read, compared and repaired. No ROS at import."""
