"""Campaigns of damaged and hostile input: serial frames, bags and texts. `make fuzz` runs them."""
