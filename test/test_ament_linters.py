# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""ROS's own linters pass, in the configurations that are here.

They come with ROS, those but `ament_copyright` with requirements-dev.txt, too.
"""

import importlib
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from cdp_ident.spdx_header import file_headers

ROOT = Path(__file__).parents[1]
CODE = [str(ROOT / name) for name in ("cdp_ident", "launch", "examples", "setup.py")]
MADE = ["--exclude", str(ROOT / "cdp_ident/model/formulas/laws.py")]


def finds_nothing(linter, configuration):
    """Run a linter in a process of its own: what it forks hangs where other tests have left threads."""
    pytest.importorskip(linter, reason=f"{linter} is not installed")
    run = f"import sys; from {linter}.main import main; sys.exit(main(sys.argv[1:]))"
    linted = subprocess.run(
        [sys.executable, "-c", run, *configuration, *MADE, "--", *CODE], capture_output=True, text=True, check=False
    )
    assert linted.returncode == 0, linted.stdout + linted.stderr


@pytest.mark.parametrize(
    ("linter", "configuration"),
    [
        ("ament_flake8", ["--config", str(ROOT / "setup.cfg")]),
        # Methods say by their names what the magic ones do; a formula is no signature, a file's key no section.
        ("ament_pep257", ["--convention", "google", "--add-ignore", "D105", "D107", "D214", "D402", "D405", "D411"]),
    ],
)
def test_ros_s_linter_finds_nothing(linter, configuration):
    finds_nothing(linter, configuration)


def test_each_file_says_whose_it_is_and_its_licence_as_ros_s_linter_asks():
    header = file_headers[0].format(copyright="Copyright 2026 cdp_ident maintainers")
    lines = "".join(f"# {line}\n" for line in header.splitlines())
    folders = ("benchmarks", "cdp_ident", "docs", "examples", "fuzz", "launch", "reference", "scenarios", "test")
    files = [ROOT / "setup.py", *(file for folder in folders for file in (ROOT / folder).rglob("*.py"))]
    assert [str(file) for file in files if not file.read_text().startswith(lines)] == []


@pytest.mark.skipif(
    not entry_points(group="ament_copyright.license", name="apache2_spdx"), reason="it is not installed"
)
def test_ros_s_linter_knows_the_header_by_the_package_s_entry_point():
    finds_nothing("ament_copyright", [])


def test_ros_s_release_tool_reads_the_version_from_the_changes():
    changelog = importlib.import_module("catkin_pkg.changelog").get_changelog_from_path(str(ROOT / "CHANGELOG.rst"))
    package = importlib.import_module("catkin_pkg.package").parse_package(str(ROOT))
    newest, _, changes = next(changelog.foreach_version(reverse=True))
    assert newest == package.version
    assert changes
