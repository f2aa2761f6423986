# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the package says about itself, to ROS's tools and to those who cite it."""

import ast
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import yaml

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
    assert {"rclpy", "rosgraph_msgs", "builtin_interfaces"} <= used <= declared


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
