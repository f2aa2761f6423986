"""Effects that the paper's model lacks: friction of other kinds, drag, springs, and what encoders do to angles."""
