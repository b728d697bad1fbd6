"""Commands and launcher: from a scenario to ROS 2 processes, and from a bag back to topics."""
