# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the code that is made of formulas is kept, and how it comes there.

That of the catalogue is made when the package is built, as the module `laws` beside this one; where it is not there, or
is another version's, it is made when it is first needed, like that of a user's own laws, and kept beside the compiled
code. Making it needs sympy, using it does not.
"""

import hashlib
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import ModuleType

from cdp_ident.errors import OptionError
from cdp_ident.machine.compilation import kept
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.formulas import language

_FOLDER = Path(__file__).parent
BUILT = _FOLDER / "laws.py"
"""What is made when the package is built."""
_MAKERS = ("code.py", "derivation.py", "language.py")


class Generated(ModuleType):
    """A module of laws' code."""

    text: str


@cache
def module_of(effects: tuple[Effect, ...], paper: bool) -> Generated:
    """Return the module with the laws of effects, and with the equations of motion or not.

    Raises `OptionError` where it has to be made, and sympy is not installed.
    """
    digest = _digest(effects, paper)
    if BUILT.exists() and f'DIGEST = "{digest}"' in (text := BUILT.read_text(encoding="utf-8")):
        return _executed(digest, text, str(BUILT), paper)
    name = f"laws_{digest}.py"
    return _executed(digest, kept(name, lambda: _text(effects, digest, paper).encode()).decode(), name, paper)


def _executed(digest: str, text: str, file: str, paper: bool) -> Generated:
    # Loops are made of the paper's equations, which are the same whatever effects the catalogue has.
    module = Generated(f"{__package__}.{BUILT.stem if paper else f'laws_{digest}'}")
    module.text = text
    sys.modules[module.__name__] = module  # where kept machine code looks for what it is made of
    exec(compile(text, file, "exec"), module.__dict__)
    return module


def build(effects: tuple[Effect, ...]) -> None:
    """Make the module of the catalogue, beside this one."""
    BUILT.write_text(_text(effects, _digest(effects, True), True), encoding="utf-8")


def _text(effects: Sequence[Effect], digest: str, paper: bool) -> str:
    try:
        from cdp_ident.model.formulas.code import module_text  # noqa: PLC0415 - sympy is not needed otherwise
    except ImportError as error:
        raise OptionError(f"laws cannot be made into code without {error.name}: pip install {error.name}") from error
    return module_text(effects, digest, paper)


def _digest(effects: Sequence[Effect], paper: bool) -> str:
    digest = hashlib.sha256(repr((paper, language.PAPER)).encode())
    for effect in effects:
        digest.update(repr((effect.key, effect.law, [p.name for p in effect.parameters])).encode())
    for name in _MAKERS:
        digest.update(_source(name))
    return digest.hexdigest()[:16]


@cache
def _source(name: str) -> bytes:
    return (_FOLDER / name).read_bytes()


if __name__ == "__main__":
    from cdp_ident.model.effects.catalogue import WRITTEN

    build(WRITTEN)
