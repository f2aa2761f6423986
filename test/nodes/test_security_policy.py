# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The SROS2 policy allows each node all that it says and hears, by the graph of nodes that run."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

POLICY = ElementTree.parse(Path(__file__).parents[2] / "config/sros2_policy.xml")


def allowed(node, kind, direction):
    """Return the names that the policy allows a node, in full."""
    (profile,) = POLICY.findall(f".//profile[@node='{node}']")
    entries = profile.findall(f"{kind}s[@{direction}='ALLOW']/{kind}")
    names = [entry.text or "" for entry in entries]
    return {f"/{node}{name[1:]}" if name.startswith("~") else f"/{name}" for name in names}


@pytest.mark.parametrize("node", ["driver", "recorder", "identify", "simulator"])
def test_everything_in_the_graph_is_allowed(listener, start, tmp_path, node):
    options = {
        "driver": ["--ros-args", "-p", f"port:={tmp_path / 'tty'}", "-p", f"zero_file:={tmp_path / 'zero.yaml'}"],
        "recorder": ["--ros-args", "-p", f"folder:={tmp_path}"],
        "identify": ["--watch", str(tmp_path), "--out", str(tmp_path / "out")],
        "simulator": ["--bag", "bags/swing_wide"],
    }
    start(node, *options[node])

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


def test_nobody_but_the_operator_and_the_simulator_may_ask_for_anything():
    asking = {
        profile.get("node") for profile in POLICY.iter("profile") if profile.find("services[@request]") is not None
    }
    assert asking == {"operator", "simulator"}
