# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is needed to repeat a run: checksums of the bags, versions of the software."""

import hashlib
import importlib.metadata
import platform
import re
from pathlib import Path

from cdp_ident.bag.reader import storage_files
from cdp_ident.errors import BagError
from cdp_ident.files import open_regular

_PACKAGES = ("cdp_ident", "numpy", "scipy", "numba", "rosbags", "mcap")
_SOURCE = Path(__file__).parents[2] / "package.xml"
"""Where the version of a package stands that is run from its source folder."""


def bag_checksums(bag: Path) -> dict[str, str]:
    """Return the SHA-256 of each file that holds messages of a bag, by the file's name.

    Raises:
        BagError: a file cannot be read.
    """
    checksums = {}
    try:
        for file in storage_files(bag):
            with open_regular(file) as stream:
                digest = hashlib.sha256()
                while block := stream.read(1 << 20):
                    digest.update(block)
            checksums[file.name] = digest.hexdigest()
    except (OSError, ValueError) as error:
        raise BagError(f"{bag} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    return checksums


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
