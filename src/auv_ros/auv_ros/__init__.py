"""Turns pure objects into ROS 2 nodes: life cycle, parameters, subscriptions, time, bytes of messages."""
