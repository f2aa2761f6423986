# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rig's serial side: wire protocol, clock, emulated rig, recording of trials. No ROS import."""
