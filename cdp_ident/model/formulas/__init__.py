"""Formulas of laws: read as text, differentiated, and made into compiled code; see `language`."""
