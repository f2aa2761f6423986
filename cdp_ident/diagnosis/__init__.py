"""How good a fit is and what it says: errors, uncertainty, what is determined, what is to be doubted."""
