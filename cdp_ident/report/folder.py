# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The folder that a report is written into."""

import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from cdp_ident.files import read_regular
from cdp_ident.output_folder import replace_files, writing

REPORT, FITTED, CURVES = "report.json", "fitted.yaml", "curves.npz"
PAGE, TEXT, FIGURES = "report.html", "report.md", "figures"
COMPARISON_PAGE, COMPARISON_TEXT = "compare.html", "compare.md"
FILES = (REPORT, FITTED, CURVES, PAGE, TEXT, FIGURES)
"""Those of a report; in the last one, a folder, there are the figures that `report.md` links to."""
PICTURES = (".png", ".svg")
"""Endings of the files that a figure is drawn as."""
State = tuple[int, int] | None
"""Which `report.json` is in a folder; None where there is none."""
_LINK = re.compile(rf"\]\({FIGURES}/([^/)]+)\.svg\)")
_LARGEST_TEXT = 1 << 24


def state_of(folder: Path) -> State:
    """Return which `report.json` is in a folder."""
    with suppress(OSError):
        file = (folder / REPORT).lstat()
        return file.st_ino, file.st_mtime_ns
    return None


def write_result(folder: Path, contents: Mapping[str, str | bytes], seen: State) -> Path:
    """Write the files of a result, `report.json` first among them; whatever was made of another one goes.

    Whenever this process is killed there is one whole `report.json`, and nothing beside it that is not of it.
    Where another process wrote a report into the folder that was not `seen` there before, that one stays and this one
    goes into a new folder beside it. Returns where it is.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    place, number = folder, 1
    while True:
        with writing(place, contents):
            if state_of(place) == seen:
                replace_files(place, contents, (*FILES[:-1], *drawn_with(place)), (FIGURES,))
                return place
        number, seen = number + 1, None
        place = folder.parent / f"{folder.name}_{number}"


def drawn_with(folder: Path) -> list[str]:
    """Return the files in FIGURES that were drawn with the `report.md` of a folder, which links to each."""
    if (folder / FIGURES).is_symlink():
        return []
    try:
        text = read_regular(folder / TEXT, _LARGEST_TEXT).decode(errors="replace")
    except OSError:
        return []
    return [f"{FIGURES}/{name}{ending}" for name in _LINK.findall(text) for ending in PICTURES]
