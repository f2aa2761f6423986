"""From the samples of a bag to a trial: one motion, free or with known inputs, in the model's angles."""
