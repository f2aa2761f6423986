"""The mechanical model: its parameters, its equations of motion, and their simulation."""
