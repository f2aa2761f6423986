"""A model's motion as it goes on: beside a recorded trial, beside a live rig, or alone; without ROS."""
