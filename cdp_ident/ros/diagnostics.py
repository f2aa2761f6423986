# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a node says of itself in `/diagnostics`, once a second, and with that severity in its log."""

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from cdp_ident.outside_text import utf_8
from cdp_ident.rig.health import Health, Level
from cdp_ident.ros.steady_timer import call_every


def log(logger: Any, level: Level, sentence: str) -> None:
    """Say something with the severity of a level; rclpy takes one severity from each line of code."""
    if level is Level.OK:
        logger.info(sentence)
    elif level is Level.ERROR:
        logger.error(sentence)
    else:
        logger.warning(sentence)


def diagnose(node: Any, report: Callable[[], Health]) -> None:
    """Publish what `report` tells, which is asked once a second, under the node's fully qualified name."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def publish() -> None:
        reported = report()
        status = DiagnosticStatus(
            level=bytes([reported.level]),
            name=node.get_fully_qualified_name(),
            message=utf_8(reported.message),
            hardware_id=utf_8(reported.hardware_id),
            values=[KeyValue(key=key, value=utf_8(value)) for key, value in reported.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    call_every(node, 1.0, publish)
