"""The configuration of `identify`, from ROS parameter files or ROS, and the library's settings made from it."""
