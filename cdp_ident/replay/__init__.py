# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model's motion as it goes on: beside a recorded trial, beside a live rig, or alone; without ROS."""
