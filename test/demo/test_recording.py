# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long the trials of a script are."""

import pytest

from cdp_ident.demo.recording import RIG, swing_times
from cdp_ident.errors import OptionError


def times(tmp_path, script):
    (tmp_path / "rig.yaml").write_text(f"script: [{script}]")
    return swing_times(tmp_path / "rig.yaml")


def test_the_demonstration_s_rig_swings_three_times():
    assert swing_times(RIG) == [12.5] * 3


def test_a_swing_lasts_until_the_hand_or_the_cart_moves(tmp_path):
    script = "wait: 1, let_go, wait: 4, wait: 3, hold: {theta1: 1, theta2: 1}, wait: 9, let_go, wait: 6, cart: {to: 1}"
    assert times(tmp_path, f"{script}, wait: 2") == [7.0, 6.0]


@pytest.mark.parametrize(
    "script", ["wait: 3", "let_go, wait: 9", "let_go, wait: 9, hold: {theta1: 1, theta2: 1}, let_go"]
)
def test_fewer_than_two_swings_are_refused(tmp_path, script):
    with pytest.raises(OptionError, match="lets go twice"):
        times(tmp_path, script)
