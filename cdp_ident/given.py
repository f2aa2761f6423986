"""Values that users give in files and parameters, checked."""

import math
from typing import Any

from cdp_ident.errors import OptionError


def number(value: Any, where: str, minimum: float, maximum: float = math.inf) -> float:
    """Return a number as a float. Raises `OptionError` where it is none, not finite, or out of its range."""
    usable = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < math.inf
    if not usable or not minimum <= value <= maximum:
        limit = f"at least {minimum:g}" if math.isinf(maximum) else f"{minimum:g} to {maximum:g}"
        raise OptionError(f"{where} is {value!r}; expected a number, {limit}")
    return float(value)
