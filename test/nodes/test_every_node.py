# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What holds of every node: example files, `ros2 param dump`, and the SROS2 policy, each by nodes that run."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

CONFIG = Path(__file__).parents[2] / "config"
POLICY = ElementTree.parse(CONFIG / "sros2_policy.xml")
RESULTS = {"m1": 0.136, "groups": {"A23_over_A22": 0.13}, "std": {"m1": 0.02}, "determined": {"m1": True}}
"""What `identify` shows beside its settings once it has a result."""
READ_ONLY = {"driver": "baud", "recorder": "longest"}
"""A parameter of each node that has a part in the example file."""


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


def allowed(node, kind, direction):
    """Return the names that the policy allows a node, in full."""
    (profile,) = POLICY.findall(f".//profile[@node='{node}']")
    entries = profile.findall(f"{kind}s[@{direction}='ALLOW']/{kind}")
    names = [entry.text or "" for entry in entries]
    return {f"/{node}{name[1:]}" if name.startswith("~") else f"/{name}" for name in names}


def assert_all_of_it_is_allowed(listener, node):
    def graph(what):
        try:
            found = getattr(listener.node, f"get_{what}_by_node")(node, "/")
        except RuntimeError:  # not discovered yet
            return set()
        return {name for name, _ in found}

    listener.wait_for(lambda: f"/{node}/set_parameters_atomically" in graph("service_names_and_types"))
    assert graph("publisher_names_and_types") <= allowed(node, "topic", "publish")
    assert graph("subscriber_names_and_types") <= allowed(node, "topic", "subscribe")
    assert graph("service_names_and_types") <= allowed(node, "service", "reply")
    assert graph("client_names_and_types") <= allowed(node, "service", "request")


@pytest.mark.parametrize("name", ["driver", "recorder", "simulator", "identify"])
def test_it_is_allowed_and_takes_the_example_its_own_dump_and_files_for_others(listener, start, tmp_path, name):
    (tmp_path / "others.yaml").write_text("camera: {ros__parameters: {exposure: 3}}")
    (tmp_path / "trials").mkdir()
    own = {
        "driver": ["--ros-args", "-p", f"port:={tmp_path / 'tty'}", "-p", f"zero_file:={tmp_path / 'zero.yaml'}"],
        "recorder": ["--ros-args", "-p", f"folder:={tmp_path / 'trials'}"],
        "simulator": ["--bag", "bags/swing_wide", "--ros-args", "-p", "source:=/identify"],
        "identify": ["--watch", str(tmp_path / "trials"), "--ros-args", "-p", "nominal.m1:=0.12"],
    }[name]
    example = ["--params-file", str(CONFIG / "rig.yaml")] if name in READ_ONLY else []
    options = own[: own.index("--ros-args")]
    others = ["--params-file", str(tmp_path / "others.yaml")]
    first = start(name, *options, "--ros-args", *example, *own[len(options) + 1 :], *others)
    before = listener.get_parameters(f"/{name}", listener.parameter_names(f"/{name}"))
    assert f"others.yaml says nothing to /{name}" in first.said
    assert_all_of_it_is_allowed(listener, name)
    for parameter in filter(None, [READ_ONLY.get(name)]):
        given = yaml.safe_load((CONFIG / "rig.yaml").read_text())[f"/**/{name}"]["ros__parameters"][parameter]
        changed, reason = listener.set_parameter(f"/{name}", parameter, given)
        assert not changed
        assert "read-only" in reason
    assert first.end() in (0, 130)
    tree = dumped(before) | (RESULTS if name in ("identify", "simulator") else {})
    tree = {key: value for key, value in tree.items() if name != "simulator" or key not in ("std", "determined")}
    (tmp_path / "dump.yaml").write_text(yaml.safe_dump({f"/{name}": {"ros__parameters": tree}}))
    again = start(name, *options, "--ros-args", "--params-file", str(tmp_path / "dump.yaml"))
    after = listener.get_parameters(f"/{name}", listener.parameter_names(f"/{name}"))
    assert after == before
    if name in ("identify", "simulator"):
        assert again.said.count("passed over") == 1


def test_nobody_but_the_operator_and_the_simulator_may_ask_for_anything():
    asking = {
        profile.get("node") for profile in POLICY.iter("profile") if profile.find("services[@request]") is not None
    }
    assert asking == {"operator", "simulator"}


def test_the_simulator_s_file_changes_nothing_and_lists_everything_that_is_its_own(listener, start):
    commented = (CONFIG / "simulator.yaml").read_text()
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
