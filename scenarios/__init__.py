"""Trials, bags and problems in the package's own types, made from `reference`, that tests and benchmarks share."""
