# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials, bags and problems in the package's own types, made from `reference`, that tests and benchmarks share."""
