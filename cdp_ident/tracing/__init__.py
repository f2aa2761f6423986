"""From the residual of a fitted model to the effects that it lacks."""
