# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the package says about itself, to ROS's tools and to those who cite it.

ROS's own linters are run by `make check`, all but `ament_copyright`, which comes with ROS alone.
"""

import ast
import importlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from importlib.metadata import entry_points
from pathlib import Path

import pytest
import yaml

from cdp_ident.spdx_header import file_headers

ROOT = Path(__file__).parents[1]
OF_ROS = re.compile(r"rclpy|launch|launch_ros|xacro|ament_index_python|\w+_(?:msgs|srvs|interfaces)")


def imported(path):
    for statement in ast.walk(ast.parse(path.read_text())):
        if isinstance(statement, ast.Import):
            yield from (name.name.split(".")[0] for name in statement.names)
        elif isinstance(statement, ast.ImportFrom) and statement.module:
            yield statement.module.split(".")[0]


def test_every_ros_package_that_is_imported_is_one_that_rosdep_installs():
    files = [*(ROOT / "cdp_ident").rglob("*.py"), *(ROOT / "launch").glob("*.py")]
    used = {name for path in files for name in imported(path) if OF_ROS.fullmatch(name)}
    declared = {element.text for element in ET.parse(ROOT / "package.xml").iter("exec_depend")}
    assert {"rclpy", "rosgraph_msgs"} <= used <= declared


def test_it_cites_this_version_under_this_licence():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    package = ET.parse(ROOT / "package.xml")
    assert citation["title"] == package.findtext("name")
    assert citation["version"] == package.findtext("version")
    assert citation["license"] == package.findtext("license")
    assert citation["authors"] == [{"name": package.findtext("author")}]
    reuse = (ROOT / "REUSE.toml").read_text()
    assert f'SPDX-License-Identifier = "{package.findtext("license")}"' in reuse
    assert package.findtext("author") in reuse


def test_it_names_the_paper_as_the_readme_does():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["references"][0]["title"] in (ROOT / "README.md").read_text()


CODE = [str(ROOT / name) for name in ("cdp_ident", "launch", "examples", "setup.py")]


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
    pytest.importorskip("ament_copyright", reason="ament_copyright is not installed")
    # In a process of its own: what it forks hangs where other tests have left threads.
    run = "import sys; from ament_copyright.main import main; sys.exit(main(sys.argv[1:]))"
    linted = subprocess.run([sys.executable, "-c", run, "--", *CODE], capture_output=True, text=True, check=False)
    assert linted.returncode == 0, linted.stdout + linted.stderr


def test_ros_s_release_tool_reads_the_version_from_the_changes():
    changelog = importlib.import_module("catkin_pkg.changelog").get_changelog_from_path(str(ROOT / "CHANGELOG.rst"))
    package = importlib.import_module("catkin_pkg.package").parse_package(str(ROOT))
    newest, _, changes = next(changelog.foreach_version(reverse=True))
    assert newest == package.version
    assert changes
