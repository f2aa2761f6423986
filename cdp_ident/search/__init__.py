"""The paper's genetic search, for any objective over a box."""
