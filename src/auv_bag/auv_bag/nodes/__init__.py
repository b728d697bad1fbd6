"""ROS 2 nodes of this package: the recorder."""
