# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Timers for what waits for the wall's time."""

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType


def call_every(node: Any, seconds: float, action: Callable[[], None]) -> None:
    """Call `action` every so many seconds of a steady clock.

    A node's own timers live in ROS's time, which may be set back and, under `use_sim_time`
    without a clock, stands still.
    """
    node.create_timer(seconds, action, clock=Clock(clock_type=ClockType.STEADY_TIME))
