# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Examples are programs, not a package: tests find them as they find each other."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "examples"))
