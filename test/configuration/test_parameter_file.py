"""ROS parameter files without ROS."""

import pytest

from cdp_ident.configuration.parameter_file import parameter_file, read_parameter_file
from cdp_ident.errors import OptionError


@pytest.fixture
def read(tmp_path):
    def run(text):
        file = tmp_path / "some.yaml"
        file.write_text(text)
        return read_parameter_file(file, "identify")

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
        ("", "says nothing to identify"),
        ("[1, 2]", "says nothing to identify"),
        ("driver: {ros__parameters: {port: x}}", "says nothing to identify"),
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
    assert read_parameter_file(tmp_path / "some.yaml", "anyone") == values
