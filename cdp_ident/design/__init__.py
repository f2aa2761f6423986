"""Which trial to record next: what it would tell, before it is recorded (optimal design of experiments)."""
