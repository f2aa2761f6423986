"""From the samples of a bag to a trial: one zero-input motion in the model's angles."""
