# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Commands of the cart as the drive gets them."""

import math

import pytest

from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Commands


def decoded(frame):
    return BinaryCodec().decode(frame.removesuffix(b"\0"))


def test_each_command_has_the_next_number_and_the_counter_s_direction():
    commands = Commands(BinaryCodec(), -1)
    assert decoded(commands.frame(1.5)) == CartCommand(1, -1500)
    assert decoded(commands.frame(-0.0004)) == CartCommand(2, 0)


@pytest.mark.parametrize("acceleration", [1e300, 2147484.0])
def test_a_command_larger_than_its_field_is_the_largest(acceleration):
    commands = Commands(BinaryCodec(), 1)
    assert decoded(commands.frame(acceleration)) == CartCommand(1, 2**31 - 1)
    assert decoded(commands.frame(-acceleration)) == CartCommand(2, 1 - 2**31)


@pytest.mark.parametrize("acceleration", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_never_sent(acceleration):
    assert Commands(BinaryCodec(), 1).frame(acceleration) == b""
