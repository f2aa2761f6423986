# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The mechanical model: its parameters, its equations of motion, and their simulation."""
