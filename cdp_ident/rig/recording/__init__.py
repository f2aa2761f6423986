"""Recording of trials: when one begins and ends, what is known of it, and how nothing of it gets lost."""
