# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""On a disk that is read-only nothing is begun: one line says so, and bags are read from it all the same."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cdp_ident.bag.reader import read_joint_states

BAG = Path(__file__).parents[2] / "bags/swing_wide"
MOUNT = 'mount --bind -o ro "$0" "$0" && cd "$0" && exec "$@"'
READ_ONLY = ["unshare", "--map-root-user", "--mount", "sh", "-c", MOUNT]
"""Runs a command in a folder, given before it, that it sees as a disk which is read-only."""


@pytest.fixture
def disk(tmp_path):
    """A folder with a bag, for READ_ONLY."""
    if subprocess.run([*READ_ONLY, tmp_path, "true"], check=False, capture_output=True).returncode:
        pytest.skip("no disks may be mounted here")
    shutil.copytree(BAG, tmp_path / "bag")
    return tmp_path


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("recorder --ros-args -p folder:=trials", "nothing can be recorded in"),
        ("recorder --ros-args -p folder:=.", "nothing can be recorded in"),
        ("identify --bag bag --once", "cannot be written to"),
        ("identify --bag bag --once --out bag", "cannot be written to"),
        ("survey bag --out found", "cannot be written to"),
        ("compare_searches --bag bag --out found", "cannot be written to"),
    ],
)
def test_nothing_is_begun_that_could_not_be_kept(disk, command, words):
    arguments = [*READ_ONLY, disk, sys.executable, "-m", "cdp_ident", *command.split()]
    done = subprocess.run(arguments, check=False, capture_output=True, text=True)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert words in line
    assert "Read-only file system" in line


def test_a_bag_is_read_from_it(disk):
    code = "from cdp_ident.bag.reader import *; print(len(read_joint_states(Path('bag'), 'joint_states').stamps))"
    done = subprocess.run([*READ_ONLY, disk, sys.executable, "-c", code], check=True, capture_output=True)
    assert int(done.stdout) == len(read_joint_states(BAG, "joint_states").stamps)
