"""A rig that is not there: its physics, the hand that lets it go, its microcontroller, its cable and their faults."""
