# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameter files without ROS."""

import pytest

from cdp_ident.configuration.parameter_file import parameter_file, read_parameter_file
from cdp_ident.errors import OptionError


@pytest.fixture
def read(tmp_path):
    def run(text, node="identify"):
        file = tmp_path / "some.yaml"
        file.write_text(text)
        return read_parameter_file(file, node)

    return run


@pytest.mark.parametrize(
    ("text", "taken"),
    [
        # A section of the node or of all nodes, whose names are nested or dotted.
        *((f"{name}: {{ros__parameters: {{window: 2.0}}}}", {"window": 2.0})
          for name in ("identify", "/identify", "/**", "/*")),
        *((f"identify: {{ros__parameters: {{{names}}}}}", {"nominal.m1": 0.1, "nominal.m2": 0.2})
          for names in ("nominal: {m1: 0.1, m2: 0.2}", "nominal.m1: 0.1, nominal.m2: 0.2")),
        # The node's own wins over that of all nodes.
        ("identify: {ros__parameters: {g: 1.0}}\n/**: {ros__parameters: {g: 2.0, L: 3.0}}", {"g": 1.0, "L": 3.0}),
        # Sections of other nodes are left alone, and an empty one says nothing.
        ("driver: {ros__parameters: {port: x}}\nidentify: {ros__parameters: {}}", {}),
        ("identify: {ros__parameters: }", {}),
    ],
)  # fmt: skip
def test_what_is_for_the_node_is_read(read, text, taken):
    assert read(text).taken() == taken


@pytest.mark.parametrize("key", ["/**/identify", "/rig1/identify", "/*/identify", "/rig1/*", "rig1/identify"])
def test_keys_are_matched_as_ros_does(read, key):
    assert read(f"{key}: {{ros__parameters: {{g: 1.0}}}}", "/rig1/identify").taken() == {"g": 1.0}
    nested = "rig1: {identify: {ros__parameters: {g: 1.0}}, driver: {ros__parameters: {}}}"
    assert read(nested, "/rig1/identify").taken() == {"g": 1.0}


@pytest.mark.parametrize("key", ["identify", "/identify", "/*", "/rig2/identify", "/**/driver"])
def test_keys_for_other_namespaces_and_names_are_not_for_this_node(read, key):
    with pytest.raises(OptionError, match="says nothing to /rig1/identify"):
        read(f"{key}: {{ros__parameters: {{g: 1.0}}}}", "/rig1/identify")


@pytest.mark.parametrize(
    "text",
    [
        "/rig1/identify: {ros__parameters: {g: 1.0}}",
        "rig1: {identify: {ros__parameters: {g: 1.0}}}",
        "/**: {ros__parameters: {g: 2.0}}\n/rig1/left/identify: {ros__parameters: {g: 1.0}}",
        "/rig1/identify: {ros__parameters: {g: 2.0}}\nidentify: {ros__parameters: {g: 1.0}}",
    ],
)
def test_a_command_takes_what_the_one_node_of_its_name_had_in_a_namespace(read, text):
    assert read(text).taken() == {"g": 1.0}


def test_of_several_namespaces_a_command_takes_none(read):
    with pytest.raises(OptionError, match="is for several nodes: /rig1/identify, /rig2/identify: keep one"):
        read("/rig1/identify: {ros__parameters: {g: 1.0}}\nrig2: {identify: {ros__parameters: {g: 2.0}}}")


@pytest.mark.parametrize(
    ("one", "other", "name"),
    [
        ("/identify", "identify", "identify"),
        ("rig1/identify", "/rig1/identify", "/rig1/identify"),
        ("/rig1/identify/", "/rig1/identify", "/rig1/identify"),
    ],
)
def test_a_node_that_stands_twice_is_refused_with_both_lines(read, one, other, name):
    with pytest.raises(OptionError, match=f"'{name}' stands twice, in line 1 and in line 2"):
        read(f"{one}: {{ros__parameters: {{g: 1.0}}}}\n{other}: {{ros__parameters: {{L: 2.0}}}}")


def test_a_node_that_stands_twice_is_refused_also_in_a_namespace(read):
    with pytest.raises(OptionError, match="stands twice, in line 1 and in line 2"):
        read("rig1: {identify: {ros__parameters: {g: 1.0}}}\n/rig1/identify: {ros__parameters: {L: 2.0}}")


def test_of_what_is_for_any_node_only_what_is_known_is_taken(read):
    found = read("/**: {ros__parameters: {g: 2.0, baud: 3}}\nidentify: {ros__parameters: {window: 1.0, gg: 4.0}}")
    assert found.taken({"g", "window"}.__contains__) == {"g": 2.0, "window": 1.0, "gg": 4.0}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("identify: [", "not YAML"),
        ("identify: {ros__parameters: {t: 2024-99-99}}", "not YAML"),
        ("\x00", "not YAML"),
        ("", "says nothing to /identify"),
        ("[1, 2]", "says nothing to /identify"),
        ("driver: {ros__parameters: {port: x}}", "says nothing to /identify"),
        ("identify: {L: 0.4}", "expected 'ros__parameters:'"),
        ("identify: 3", "expected 'ros__parameters:'"),
        ("identify: {ros__parameters: [1]}", "expected names and values"),
        ("identify: {ros__parameters: &a {b: *a}}", "aliases are not taken"),
        ("identify: {ros__parameters: " + 12 * "{a: " + "1" + 12 * "}" + "}", "nested too deep"),
    ],
)
def test_a_file_that_is_none_is_refused(read, text, words):
    with pytest.raises(OptionError, match=words):
        read(text)


def test_a_missing_file_and_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "some.yaml").write_bytes(b"\xff\xfe\x00\xd8")
    for name, words in (
        ("some.yaml", "not YAML"),
        ("there.yaml", r"there\.yaml cannot be read"),
        (".", "cannot be read"),
    ):
        with pytest.raises(OptionError, match=words):
            read_parameter_file(tmp_path / name, "identify")


def test_what_is_written_is_read_again(tmp_path):
    values = {"m1": 0.1, "c2": 1e-7, "std.m1": float("inf"), "L": 4.0, "n": 3}
    values |= {"determined.m1": False, "name": "a: b # c"}
    (tmp_path / "some.yaml").write_text(parameter_file(values, ["a comment"]))
    assert read_parameter_file(tmp_path / "some.yaml", "anyone").for_any == values
