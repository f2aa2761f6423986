"""The commands that need no ROS."""
