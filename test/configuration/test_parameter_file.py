# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameter files without ROS."""

import pytest

from cdp_ident.configuration.parameter_file import parameter_file, read_parameter_file
from cdp_ident.errors import OptionError


@pytest.fixture
def read(tmp_path):
    def run(text):
        file = tmp_path / "some.yaml"
        file.write_text(text)
        return read_parameter_file(file, "identify").taken()

    return run


@pytest.mark.parametrize("name", ["identify", "/identify", "/**", "/*"])
def test_a_section_of_the_node_or_of_all_nodes_is_read(read, name):
    assert read(f"{name}: {{ros__parameters: {{window: 2.0}}}}") == {"window": 2.0}


def test_nested_and_dotted_names_are_the_same(read):
    nested = read("identify: {ros__parameters: {nominal: {m1: 0.1, m2: 0.2}}}")
    assert nested == read("identify: {ros__parameters: {nominal.m1: 0.1, nominal.m2: 0.2}}")
    assert nested == {"nominal.m1": 0.1, "nominal.m2": 0.2}


def test_the_node_s_own_section_wins_over_that_of_all_nodes(read):
    assert read("identify: {ros__parameters: {g: 1.0}}\n/**: {ros__parameters: {g: 2.0, L: 3.0}}") == {
        "g": 1.0,
        "L": 3.0,
    }


@pytest.mark.parametrize("key", ["/**/identify", "/rig1/identify", "/*/identify", "/rig1/*", "rig1/identify"])
def test_keys_are_matched_as_ros_does(tmp_path, key):
    (tmp_path / "some.yaml").write_text(f"{key}: {{ros__parameters: {{g: 1.0}}}}")
    assert read_parameter_file(tmp_path / "some.yaml", "/rig1/identify").taken() == {"g": 1.0}


@pytest.mark.parametrize("key", ["identify", "/identify", "/*", "/rig2/identify", "/**/driver"])
def test_keys_for_other_namespaces_and_names_are_not_for_this_node(tmp_path, key):
    (tmp_path / "some.yaml").write_text(f"{key}: {{ros__parameters: {{g: 1.0}}}}")
    with pytest.raises(OptionError, match="says nothing to /rig1/identify"):
        read_parameter_file(tmp_path / "some.yaml", "/rig1/identify")


def test_namespaces_may_be_nested(tmp_path):
    (tmp_path / "some.yaml").write_text("rig1: {identify: {ros__parameters: {g: 1.0}}, driver: {ros__parameters: {}}}")
    assert read_parameter_file(tmp_path / "some.yaml", "/rig1/identify").taken() == {"g": 1.0}


def test_of_what_is_for_any_node_only_what_is_known_is_taken(tmp_path):
    (tmp_path / "some.yaml").write_text(
        "/**: {ros__parameters: {g: 2.0, baud: 3}}\nidentify: {ros__parameters: {window: 1.0, gg: 4.0}}"
    )
    found = read_parameter_file(tmp_path / "some.yaml", "identify")
    assert found.taken({"g", "window"}.__contains__) == {"g": 2.0, "window": 1.0, "gg": 4.0}


def test_sections_of_other_nodes_are_left_alone(read):
    assert read("driver: {ros__parameters: {port: x}}\nidentify: {ros__parameters: {}}") == {}


def test_an_empty_section_says_nothing(read):
    assert read("identify: {ros__parameters: }") == {}


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


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "some.yaml").write_bytes(b"\xff\xfe\x00\xd8")
    with pytest.raises(OptionError, match="not YAML"):
        read_parameter_file(tmp_path / "some.yaml", "identify")


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(OptionError, match=r"there\.yaml cannot be read"):
        read_parameter_file(tmp_path / "there.yaml", "identify")
    with pytest.raises(OptionError, match="cannot be read"):
        read_parameter_file(tmp_path, "identify")


def test_what_is_written_is_read_again(tmp_path):
    values = {
        "m1": 0.1,
        "c2": 1e-7,
        "std.m1": float("inf"),
        "L": 4.0,
        "determined.m1": False,
        "name": "a: b # c",
        "n": 3,
    }
    (tmp_path / "some.yaml").write_text(parameter_file(values, ["a comment"]))
    assert read_parameter_file(tmp_path / "some.yaml", "anyone").for_any == values
