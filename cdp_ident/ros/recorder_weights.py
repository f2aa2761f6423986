# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The parameters that say which weights are clamped to the rods; they may change from trial to trial."""

from typing import Any

from cdp_ident.model.weights import ADDED, ADDED_STD, DESCRIPTIONS, NOTHING, RODS, Weight, weights_of
from cdp_ident.ros.parameters import Parameters


class RecorderWeights:
    """Keeps the weights that the parameters `added.<rod>` and `added_std.<rod>` of a node describe."""

    def __init__(self, node: Any, parameters: Parameters) -> None:
        """Raises `OptionError` where a value that the user gave is not possible."""
        self._values = {
            f"{what}.{rod}": parameters.declare(
                f"{what}.{rod}", list(NOTHING), DESCRIPTIONS[what].format(rod=rod), minimum=0.0, changeable=True
            )
            for what in (ADDED, ADDED_STD)
            for rod in RODS
        }
        self.now = _weights(self._values)
        """Those that are on the rods."""
        parameters.check_changes(lambda changed: _weights(self._changed(changed)))
        node.add_post_set_parameters_callback(self._follow)

    def _changed(self, parameters: list[Any]) -> dict[str, list[float]]:
        return self._values | {p.name: list(p.value or ()) for p in parameters if p.name in self._values}

    def _follow(self, parameters: list[Any]) -> None:
        self._values = self._changed(parameters)
        self.now = _weights(self._values)


def _weights(values: dict[str, list[float]]) -> tuple[Weight, ...]:
    """Return the weights; standard deviations that are all 0 are those of a weight for which none are given."""
    given = {name: value for name, value in values.items() if name.startswith(f"{ADDED}.") or any(value)}
    return tuple(weight for weight in weights_of(given, "recorder").values() if weight)
