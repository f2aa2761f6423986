"""From windows of trials to the values that fit them best: windows, model, prior, refinement."""
