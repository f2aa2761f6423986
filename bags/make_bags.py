# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Record the example bags anew: `make build`, then `PYTHONPATH=. .venv/bin/python bags/make_bags.py FOLDER`.

They are recordings of an emulated rig through driver and recorder, as README.md beside this file says.
"""

import sys
import tempfile
from pathlib import Path

from cdp_ident.demo.nodes import Nodes, own_domain
from cdp_ident.demo.recording import RIG, record_trials

NAMES = ("swing_wide", "swing_folded", "swing_check")
"""Of the rig's swings, in their order."""


def make_bags(folder: Path) -> None:
    """Record the rig's swings into bags of these names in a folder. Bags that are there already are not touched."""
    if there := [name for name in NAMES if (folder / name).exists()]:
        raise SystemExit(f"{folder} holds {', '.join(there)} already: give another folder")
    own_domain()
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as name:
        with Nodes(Path(name) / "logs") as nodes:
            recorded = record_trials(nodes, RIG, Path(name), print)
        for bag, new_name in zip(recorded, NAMES, strict=True):
            rename(bag, folder / new_name)


def rename(bag: Path, target: Path) -> None:
    """Move a bag, and give its files the new name too."""
    metadata = bag / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace(bag.name, target.name))
    for file in bag.glob(f"{bag.name}*"):
        file.rename(file.with_name(file.name.replace(bag.name, target.name)))
    bag.rename(target)


if __name__ == "__main__":
    make_bags(Path(sys.argv[1]))
