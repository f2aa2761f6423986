# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The configuration of `identify`, from ROS parameter files or ROS, and the library's settings made from it."""
