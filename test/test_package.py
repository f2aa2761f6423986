# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the package says about itself to ROS's tools."""

import ast
import re
import xml.etree.ElementTree as ET
from pathlib import Path

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
