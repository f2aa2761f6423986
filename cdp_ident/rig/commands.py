# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Commands of the cart's acceleration as frames."""

import math

from cdp_ident.rig.codec import Codec
from cdp_ident.rig.records import UNSIGNED_32, CartCommand

_LARGEST = 2**31 - 1


class Commands:
    """Numbers commands, in the order in which they are sent."""

    def __init__(self, codec: Codec, cart_sign: int) -> None:
        """`cart_sign` is -1 where the cart's counter runs against its positive direction."""
        self._codec, self._sign, self._sequence = codec, cart_sign, 0

    def frame(self, acceleration: float) -> bytes:
        """Return the frame of the next command [m/s^2]; none of one that is no finite number: the drive then brakes."""
        if not math.isfinite(acceleration):
            return b""
        self._sequence = (self._sequence + 1) & UNSIGNED_32
        in_mm = round(min(max(1e3 * self._sign * acceleration, -_LARGEST), _LARGEST))
        return self._codec.encode(CartCommand(self._sequence, in_mm))
