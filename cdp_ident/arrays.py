# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What arrays of numbers are called, and dataclasses whose arrays have one row for each sample."""

from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Times = npt.NDArray[np.int64]
"""In nanoseconds, which floats of seconds since 1970 do not resolve."""

_Some = TypeVar("_Some", bound="Rows")


@dataclass(frozen=True)
class Rows:
    """A dataclass whose arrays, its own and those of its `Rows`, have one row for each sample."""

    def __getitem__(self: _Some, chosen: Mask | Indices | slice) -> _Some:
        """Return some of the samples."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(
            self, **{name: rows[chosen] for name, rows in values.items() if isinstance(rows, np.ndarray | Rows)}
        )
