"""What turns pure objects into ROS 2 nodes: life cycle, parameters, hearing, time, bytes of messages."""
