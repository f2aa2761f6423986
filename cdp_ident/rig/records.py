# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a rig sends, samples of its encoders and now and then a greeting; and what it is sent, commands of its cart."""

from enum import IntFlag
from typing import NamedTuple

UNSIGNED_32 = 0xFFFFFFFF
PROTOCOL_VERSION = 1
"""Version of the frames that this package speaks; docs/reference/protocol.md describes them byte for byte."""


class Status(IntFlag):
    """Bits of a sample's status flags; the others are reserved and sent as zero."""

    CART_FAULT = 1
    """The cart's encoder cannot be trusted (no signal, bad quadrature)."""
    INNER_FAULT = 2
    """The inner joint's encoder cannot be trusted."""
    OUTER_FAULT = 4
    """The outer joint's encoder cannot be trusted."""
    OVERRUN = 8
    """The device missed an instant of sampling before this sample."""


ENCODER_FAULTS = Status.CART_FAULT | Status.INNER_FAULT | Status.OUTER_FAULT


class Sample(NamedTuple):
    """The counters of all encoders, read at one instant."""

    sequence: int
    """Number of the sample since the device started, unsigned 32 bit, rolls over."""
    time_us: int
    """The device's clock at the instant of reading [us], unsigned 32 bit, rolls over every 71.6 minutes."""
    cart: int
    """Counter of the cart's encoder, signed 32 bit, rolls over; likewise the next two."""
    inner: int
    outer: int
    status: int = 0
    """Bits of `Status`."""


class Hello(NamedTuple):
    """The device's greeting, sent when it starts and about once a second from then on."""

    period_us: int
    """Time between samples [us], unsigned 32 bit."""
    inner_counts: int
    """Counts of the inner encoder per turn, after quadrature decoding, unsigned 32 bit; likewise the next."""
    outer_counts: int
    firmware: str
    """Name and version of the firmware: printable ASCII without `,` and `*`, up to 32 characters."""


class CartCommand(NamedTuple):
    """What the host asks of the cart's drive until the next command comes, or for `WATCHDOG_SECONDS`."""

    sequence: int
    """Number of the command, unsigned 32 bit, rolls over."""
    acceleration: int
    """Of the cart [mm/s^2], positive where the cart's counter grows; signed 32 bit."""


WATCHDOG_SECONDS = 0.05
"""A drive that has had no command for so long [s] brakes."""

Record = Sample | Hello | CartCommand


def signed_32(number: int) -> int:
    """Return a number as a signed counter of 32 bit shows it; of a difference of two counters, roll-over removed."""
    return ((number + 2**31) & UNSIGNED_32) - 2**31
