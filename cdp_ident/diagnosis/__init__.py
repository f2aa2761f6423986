"""How good a fit is, and what it determines: errors, uncertainty, identifiability, warnings."""
