# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `ros2 param dump` writes of a node is taken by that node."""

import pytest
import yaml

RESULTS = {"m1": 0.136, "groups": {"A23_over_A22": 0.13}, "std": {"m1": 0.02}, "determined": {"m1": True}}
"""What `identify` shows beside its settings once it has a result."""


def dumped(values):
    """Return parameters as `ros2 param dump` nests them."""
    tree = {}
    for name, value in values.items():
        *parts, last = name.split(".")
        branch = tree
        for part in parts:
            branch = branch.setdefault(part, {})
        branch[last] = list(value) if isinstance(value, list | tuple) else value
    return tree


@pytest.mark.parametrize("name", ["driver", "recorder", "simulator", "identify"])
def test_a_node_takes_its_own_dump_and_passes_over_a_file_for_others(listener, start, tmp_path, name):
    (tmp_path / "others.yaml").write_text("camera: {ros__parameters: {exposure: 3}}")
    (tmp_path / "trials").mkdir()
    own = {
        "driver": ["--ros-args", "-p", f"port:={tmp_path / 'tty'}"],
        "recorder": ["--ros-args", "-p", f"folder:={tmp_path / 'trials'}"],
        "simulator": ["--ros-args", "-p", "source:=/elsewhere"],
        "identify": ["--watch", str(tmp_path / "trials"), "--ros-args", "-p", "nominal.m1:=0.12"],
    }[name]
    first = start(name, *own, "--params-file", str(tmp_path / "others.yaml"))
    before = listener.get_parameters(f"/{name}", listener.parameter_names(f"/{name}"))
    assert f"others.yaml says nothing to /{name}" in first.said
    assert first.end() in (0, 130)
    tree = dumped(before) | (RESULTS if name in ("identify", "simulator") else {})
    tree = {key: value for key, value in tree.items() if name != "simulator" or key not in ("std", "determined")}
    (tmp_path / "dump.yaml").write_text(yaml.safe_dump({f"/{name}": {"ros__parameters": tree}}))
    options = own[: own.index("--ros-args")]
    again = start(name, *options, "--ros-args", "--params-file", str(tmp_path / "dump.yaml"))
    after = listener.get_parameters(f"/{name}", listener.parameter_names(f"/{name}"))
    assert after == before
    if name in ("identify", "simulator"):
        assert again.said.count("passed over") == 1
