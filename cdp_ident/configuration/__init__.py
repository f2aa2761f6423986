"""What `identify` can be told, in a ROS parameter file or by ROS, and what the library makes of it."""
