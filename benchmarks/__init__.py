"""How fast and how good the package is, beside what a user would use instead: one module a topic."""
