# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The whole way from an emulated rig to served parameters, each node a process of its own as on a real rig."""
