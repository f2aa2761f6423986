"""Unknown names in options and files: say which known name was probably meant."""

import difflib
from collections.abc import Iterable

from cdp_ident.errors import OptionError


def refuse_unknown(names: Iterable[str], known: Iterable[str], where: str) -> None:
    """Raise an `OptionError` for the first of `names` that is not `known`; it tells the nearest known name.

    `where` says where the name stands, such as "parameter" or "key in 'rig.yaml'".
    """
    known = sorted(known)
    for name in names:
        if name not in known:
            raise OptionError(f"unknown {where}: {name!r}; {_hint(str(name), known)}")


def _hint(name: str, known: list[str]) -> str:
    nearest = [other for other in known if other.casefold() == name.casefold()]
    nearest = nearest or difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    if nearest:
        return f"did you mean {nearest[0]!r}?"
    return f"known are {', '.join(known)}" if known else "none is known here"
