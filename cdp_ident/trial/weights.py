# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The weights that a bag says were clamped to the rods."""

import json
from collections.abc import Mapping
from pathlib import Path

from cdp_ident.bag.metadata import read_custom_data
from cdp_ident.errors import OptionError, TrialError
from cdp_ident.model.weight_settings import ADDED, weights_of
from cdp_ident.model.weights import Weight

_SALVAGED = "salvaged"


def recorded_weights(bag: Path) -> tuple[tuple[Weight, ...], list[str]]:
    """Return the weights that the recorder wrote into a bag's metadata, and what casts doubt on that, in words.

    Raises:
        TrialError: they are not possible.
    """
    custom, problem = read_custom_data(bag)
    notes = [problem] if problem else []
    if _SALVAGED in custom:
        notes.append(
            "the recorder was killed: whether weights were on the rods is not known; trials.<bag>.added tells it"
        )
    text = custom.get(ADDED, "")
    try:
        given = json.loads(text) if text else {}
    except (ValueError, RecursionError) as error:
        raise TrialError(f"{bag}: '{ADDED}' in its metadata is not JSON: {error}") from error
    if not isinstance(given, Mapping):
        raise TrialError(f"{bag}: '{ADDED}' in its metadata must name weights by rod")
    try:
        found = weights_of(given, f"{bag}: metadata")
    except OptionError as error:
        raise TrialError(str(error)) from error
    return tuple(weight for weight in found.values() if weight), notes
