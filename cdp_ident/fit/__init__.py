"""From measured angles to fitted values."""
