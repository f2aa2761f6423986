# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scripts of the hand."""

import pytest
import yaml

from cdp_ident.errors import OptionError
from cdp_ident.rig.emulator.script import Hold, LetGo, MoveCart, Wait, WaitForCommand, parse_script


def test_a_script_is_read_in_its_order():
    text = "[wait: 2, hold: {theta1: 1.0, theta2: 2}, wait_for_command, let_go, cart: {to: 0.1, within: 0.5}]"
    commands = (Wait(2.0), Hold(1.0, 2.0), WaitForCommand(), LetGo(), MoveCart(0.1, 0.5))
    assert parse_script(yaml.safe_load(text), "x") == commands


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "expected a list"),
        ("3", "expected a list"),
        ("[wiat: 2]", "did you mean 'wait'?"),
        ("[wait]", "entry 1"),
        ("[wait: -1]", "0 to 1e+06"),
        ("[wait: soon]", "expected a number"),
        ("[wait: .nan]", "expected a number"),
        ("[wait: true]", "expected a number"),
        ("[hold: 3]", "expected keys (theta1, theta2, within)"),
        ("[hold: {theta1: 1.0}]", "theta2 is missing"),
        ("[let_go, hold: {theta1: 1.0, theta2: 1, whithin: 1}]", "did you mean 'within'?"),
        ("[hold: {theta1: 1.0, theta2: 1, within: 0}]", "0.01 to 1e+06"),
        ("[cart: {to: 1, within: 1.0e+300}]", "0.01 to 1e+06"),
        ("[let_go: 3]", "takes no value"),
        ("[{wait: 1, cart: {to: 1}}]", "expected one of"),
    ],
)
def test_what_is_no_script_is_refused_with_its_place(text, words):
    content = yaml.safe_load(text)
    with pytest.raises(OptionError, match=r"rig\.yaml") as caught:
        parse_script(content, "rig.yaml: script")
    assert words in str(caught.value)
