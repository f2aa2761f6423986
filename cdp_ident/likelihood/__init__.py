"""The likelihood of whole swings."""
