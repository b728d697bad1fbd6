"""Bytes on the wire: ROS messages made from the data of components, and read back."""
