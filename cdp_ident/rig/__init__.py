"""The rig's serial side: wire protocol, clock, emulated rig, recording of trials. No ROS import."""
