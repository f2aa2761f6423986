"""An independent statement of the pendulum's physics, which tests and benchmarks hold the package against."""
