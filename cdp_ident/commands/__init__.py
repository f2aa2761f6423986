"""The commands that need no ROS; every public module here is an executable."""
