# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reading, writing and completing rosbag2 bags, without ROS."""
