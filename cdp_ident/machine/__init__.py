"""Machine code: what is compiled, where it is kept, how it is called, and how work is shared out among the cores."""
