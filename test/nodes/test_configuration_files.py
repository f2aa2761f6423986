# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The example files are what the nodes declare."""

from pathlib import Path

import pytest
import yaml

CONFIG = Path(__file__).parents[2] / "config"
FILE = CONFIG / "rig.yaml"


@pytest.mark.parametrize("node", ["driver", "recorder"])
def test_every_key_of_the_example_is_a_parameter(listener, start, tmp_path, node):
    overrides = {"driver": ["-p", f"port:={tmp_path / 'tty'}"], "recorder": ["-p", f"folder:={tmp_path / 'trials'}"]}
    process = start(node, "--ros-args", "--params-file", str(FILE), *overrides[node])
    name = "baud" if node == "driver" else "longest"
    changed, reason = listener.set_parameter(
        f"/{node}", name, yaml.safe_load(FILE.read_text())[f"/**/{node}"]["ros__parameters"][name]
    )
    assert not changed
    assert "read-only" in reason
    assert process.popen.poll() is None


def test_the_simulator_s_file_changes_nothing_and_lists_everything_that_is_its_own(listener, start):
    text = (CONFIG / "simulator.yaml").read_text()
    commented = text
    for optional in ("A22", "groups", "outer_rod"):
        commented = commented.replace(f"    # {optional}", f"    {optional}")
    listed = yaml.safe_load(commented)["/**/simulator"]["ros__parameters"]
    start("simulator", "--ros-args", "-r", "__node:=plain")
    start("simulator", "--ros-args", "--params-file", str(CONFIG / "simulator.yaml"))
    for node in ("/plain", "/simulator"):
        values = listener.get_parameters(node, list(listed))
        for name in listed:
            expected = listed[name] if isinstance(listed[name], str | bool) else pytest.approx(listed[name], rel=1e-5)
            assert values[name] == expected, name
    elsewhere = ("trial.", "qos_overrides.", "use_sim_time", "start_type_description_service")
    declared = {name for name in listener.parameter_names("/plain") if not name.startswith(elsewhere)}
    assert declared <= set(listed)
