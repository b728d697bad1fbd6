"""ROS 2 nodes of this package: parameters, subscriptions, one step call, publishers."""
