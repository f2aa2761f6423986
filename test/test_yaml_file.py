# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""YAML from outside is read within limits, and whatever is wrong with it is one short line."""

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings
from cdp_ident.errors import CdpIdentError
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.rig.joints import load_zero
from cdp_ident.yaml_file import LARGEST, read_yaml

ALIAS_BOMB = "a0: &a0 {x: 1}\n" + "".join(
    f"a{i}: &a{i} {{{', '.join(f'k{j}: *a{i - 1}' for j in range(9))}}}\n" for i in range(1, 9)
)
HOSTILE = {
    "alias bomb": ALIAS_BOMB,
    "int of nothing": "a: !!int ''",
    "timestamp of letters": "a: !!timestamp x",
    "an impossible date": "a: 2024-99-99",
    "nested lists": "[" * 100_000,
    "nested maps": "{a: " * 10_000,
    "nested blocks": "".join(f"{' ' * i}a:\n" for i in range(1000)),
    "a long value": "a: " + "x" * 100_000,
    "many values": "[" + "1," * 20_000 + "]",
    "python": "!!python/object/apply:os.system [ls]",
    "a huge file": "#" * (LARGEST + 1),
    "no text": "\x00\x1b",
    "two documents": "--- a\n--- b",
    "half a character": '"\\ud800"',
}
NUMBERS = {"400 digits": "1" * 400, "5000 hexadecimal digits": "0x" + "f" * 4000, "infinity": ".inf", "none": "~"}
LOADERS = {
    "parameters": lambda path: Settings.of(read_parameter_file(path, "identify").taken()),
    "rig": load_rig,
    "zero": load_zero,
}
PLACES = {
    "parameters": "identify: {{ros__parameters: {{L: {}}}}}",
    "rig": "rate: {}",
    "zero": "{{cart_counts: {}, inner_counts: 0, outer_counts: 0, sequence: 0, taken_at_ns: 0}}",
}


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("identify: {ros__parameters: {L: 0.3}}\n/driver: {}\nidentify: {ros__parameters: {g: 9.8}}\n", (1, 3)),
        ("/**:\n  ros__parameters:\n    L: 0.3\n    L: 0.4\n", (3, 4)),
        ("{a: 1, a: 2}", (1, 1)),
        ("identify:\n  nominal.m1: 0.1\n  nominal: {m1: 0.2}\n", (2, 3)),
        ("a: {b: {c: 1}}\nd: 1\na.b: {c: 2}\n", (1, 3)),
    ],
)
def test_a_key_that_stands_twice_is_refused_with_both_lines(tmp_path, text, lines):
    (tmp_path / "some.yaml").write_text(text)
    with pytest.raises(ValueError, match="stands twice, in line {} and in line {}".format(*lines)):
        read_yaml(tmp_path / "some.yaml")


def test_a_key_may_stand_once_in_each_section(tmp_path):
    (tmp_path / "some.yaml").write_text("a: {L: 1}\nb: {L: 2}\n'1': x\n1: y\n")
    assert read_yaml(tmp_path / "some.yaml") == {"a": {"L": 1}, "b": {"L": 2}, "1": "x", 1: "y"}


@pytest.mark.parametrize("loader", LOADERS)
@pytest.mark.parametrize("text", [*HOSTILE.values(), *NUMBERS.values()], ids=[*HOSTILE, *NUMBERS])
def test_every_loader_refuses_it_as_one_error_of_its_own(tmp_path, loader, text):
    path = tmp_path / "some.yaml"
    path.write_text(PLACES[loader].format(text) if text in NUMBERS.values() else text)
    with pytest.raises(CdpIdentError) as refused:
        LOADERS[loader](path)
    assert len(str(refused.value)) < 1000
    assert str(refused.value).isprintable()


@pytest.mark.parametrize("loader", LOADERS)
@pytest.mark.parametrize("name", ["/dev/zero", "pipe", "."])
def test_every_loader_refuses_what_is_no_regular_file(tmp_path, monkeypatch, loader, name):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    with pytest.raises(CdpIdentError, match="cannot be read"):
        LOADERS[loader](tmp_path / name)


@given(st.text(max_size=300))
def test_any_text_is_read_or_refused(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("yaml") / "some.yaml"
    path.write_text(text, errors="replace")
    try:
        read_yaml(path)
    except ValueError as error:
        assert "\n" not in str(error)  # noqa: PT017 - being read is as good
