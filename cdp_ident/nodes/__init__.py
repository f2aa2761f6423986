"""The ROS 2 nodes, each a thin layer over the library; every public module here is an executable."""
