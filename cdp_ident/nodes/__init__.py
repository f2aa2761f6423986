# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 nodes, each a thin layer over the library."""
