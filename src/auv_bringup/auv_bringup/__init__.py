"""Commands and launcher: they fly scenarios as ROS 2 processes and publish bags again."""
