# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much can be written to a folder."""

import shutil
import tempfile
from pathlib import Path


def free_space(folder: Path) -> int:
    """Return the free space on a folder's disk [bytes]. Raises `OSError` where nothing can be written to the folder."""
    with tempfile.TemporaryFile(dir=folder):
        pass
    return shutil.disk_usage(folder).free
