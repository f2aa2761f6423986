# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is needed to repeat a run, beside the bags and their checksums: versions of the software."""

import importlib.metadata
import platform
import re
from pathlib import Path

_PACKAGES = ("cdp_ident", "numpy", "scipy", "numba", "rosbags", "mcap")
_SOURCE = Path(__file__).parents[2] / "package.xml"
"""Where the version of a package stands that is run from its source folder."""


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that numbers depend on."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = _version_in_source() if name == "cdp_ident" else "not installed as a package"
    return found


def _version_in_source() -> str:
    found = re.search(r"<version>(.+?)</version>", _SOURCE.read_text()) if _SOURCE.exists() else None
    return f"{found[1]}, from its source folder" if found else "unknown"
