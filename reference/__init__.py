# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""An independent statement of the pendulum's physics, which tests and benchmarks hold the package against."""
