# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Services of people's tools: `std_srvs/Trigger`, answered by what an action returns or raises."""

from collections.abc import Callable
from typing import Any

from std_srvs.srv import Trigger

from cdp_ident.errors import CdpIdentError
from cdp_ident.outside_text import shown, utf_8


def serve(node: Any, name: str, action: Callable[[], object]) -> None:
    """Serve `name`: the answer is what `action` returns, or no success with what it raises, which is logged too."""

    def answer(_request: Any, response: Any) -> Any:
        try:
            response.success, response.message = True, utf_8(action())
        except CdpIdentError as error:
            response.success, response.message = False, shown(error)
            node.get_logger().warning(response.message)
        return response

    node.create_service(Trigger, name, answer)
