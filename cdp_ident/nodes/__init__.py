"""The ROS 2 nodes, each a thin layer over the library."""
