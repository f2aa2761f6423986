"""Reading, writing and completing rosbag2 bags, without ROS."""
