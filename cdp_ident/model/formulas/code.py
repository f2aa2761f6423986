# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python code for the compiler, made of their formulas: readable, and without a derivative that is zero.

A law's function takes the inputs (see `language.INPUTS`), its parameters, sums of all laws to add to, and rows of its
own to fill in. What it adds to torques and to the cart's acceleration, and the derivatives of that by what all laws
share, goes to the sums; derivatives by its own states and parameters, and everything else, to its rows. What is always
zero is left out.
"""

import ast
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.effect import Effect, Law
from cdp_ident.model.formulas import language as words
from cdp_ident.model.formulas.algebra import Tree, as_number, names_in, negative
from cdp_ident.model.formulas.derivation import Definitions

_ROWS = (
    *("torque on theta1", "torque on theta2", "friction", "cart", "rate 1", "rate 2"),
    *("inner reading", "outer reading", "lateness"),
)
"""What rows are called, in their order."""
_PAPER_INPUTS = {"turned": words.TURNED, "speeds": words.STATE[2:], "pendulum": words.COEFFICIENTS}
"""Inputs of the equations of motion beside the cart's acceleration u, as tuples that have names."""
_PAPER = Effect("equations of motion", "base", "", Law(torques=words.PAPER), (), "the paper")
"""What is left of the equations of motion, as a law."""


def rows_of(effect: Effect, at_zero: bool = False) -> Mapping[int, str]:
    """Return the formulas of what a law adds, by row; nothing where it does nothing else without strength."""
    law = effect.law
    if effect.curve is not None or (at_zero and not effect.known_at_zero):
        return {}
    rows = {words.FRICTION: law.friction, words.CART: law.cart, words.LATENESS: law.lateness}
    torque = f"-direction*({law.friction})" if law.friction else law.torque
    if torque:
        rows[words.TORQUE1], rows[words.TORQUE2] = (torque, "") if effect.joint == "inner" else (f"-({torque})", torque)
    else:
        rows[words.TORQUE1], rows[words.TORQUE2] = law.torques
    rows[words.INNER], rows[words.OUTER] = law.readings
    if law.reading:
        rows[words.OUTER if effect.joint == "outer" else words.INNER] = law.reading
    if not at_zero:
        rows |= {words.RATES + k: state.rate for k, state in enumerate(law.states)}
    return {row: rows[row] for row in sorted(rows) if rows[row]}


def name_of(effect: Effect, at_zero: bool = False) -> str:
    """Return the name of a law's function; harmonics have the same one, for they differ by a parameter alone."""
    parts = effect.name, effect.joint, "" if effect.harmonic else effect.variant, "at_zero" if at_zero else "law"
    return re.sub(r"\W", "_", "_".join(filter(None, parts)))


def text_of(effects: Sequence[Effect]) -> str:
    """Return the functions of the laws of effects, of which each is there once."""
    functions: dict[str, str] = {}
    for effect, at_zero in product(effects, (False, True)):
        name, rows = name_of(effect, at_zero), rows_of(effect, at_zero)
        if rows and name not in functions:
            functions[name] = _law(name, effect, rows, at_zero)
    return "\n\n".join(functions.values())


def _law(function: str, effect: Effect, rows: Mapping[int, str], at_zero: bool) -> str:
    """Return the function of a law, or of one that has no strength."""
    definitions, parameters = Definitions(f"{effect.name}.{effect.joint}", effect.joint), effect.parameters
    for p in parameters:
        definitions.add_input(p.name)
    for state, own in zip(effect.law.states, words.OWN, strict=False):
        if at_zero:
            definitions.add(state.name, state.at_zero)
        else:
            definitions.add_input(state.name, own)
    for defined, text in effect.law.where:
        definitions.add(defined, text)
    columns = ("value", *words.VARIABLES, *(p.name for p in parameters))
    strengths = [p.name for p in parameters if not (p.shape or p.fixed)]
    results = dict[tuple[int, int], Tree]()
    for row, text in rows.items():
        value = definitions.value(_ROWS[row], text)
        slopes = {column: definitions.slope(value, by) for column, by in enumerate(columns) if column > 0}
        if row < words.RATES:
            _refuse_accelerations(definitions, f"{effect.key}: {_ROWS[row]}", row, slopes)
        if row == words.FRICTION:
            slopes = {}  # its torques have them
        if at_zero:
            slopes = {column: tree for column, tree in slopes.items() if columns[column] in strengths}
        results |= {(row, column): tree for column, tree in slopes.items() if as_number(tree) != 0.0} | {
            (row, 0): value
        }
    results, needed = definitions.given(results, dict.fromkeys(strengths, 0) if at_zero else {})
    inputs = {name: f"z[{k}]" for k, name in enumerate(words.INPUTS)}
    inputs |= {p.name: f"p[{k}]" for k, p in enumerate(parameters)}
    lines, width = _body(needed, results.values(), inputs), words.PARAMETERS + len(parameters)
    for (row, column), tree in sorted(results.items(), key=lambda item: item[0]):
        if at_zero and as_number(tree) == 0.0:
            continue
        what = _ROWS[row] if column == 0 else f"{_ROWS[row]} by {columns[column]}"
        is_shared = row in words.SUMS and columns[column] not in words.OWN and column < words.PARAMETERS
        of_sums = words.SUMS.index(row) * words.PARAMETERS + column if is_shared else 0
        place = f"sums[{of_sums}] +" if is_shared else f"rows[{row * width + column}] "
        lines.append(f"{place}= {ast.unparse(tree)}  # {what}")
    return _function(function, "z, p, sums, rows", effect.formula, lines)


def _refuse_accelerations(definitions: Definitions, what: str, row: int, slopes: Mapping[int, Tree]) -> None:
    """Refuse a law that is not linear in the accelerations, or a friction that depends on them at all."""
    for name in words.ACCELERATIONS:
        slope = slopes[1 + words.VARIABLES.index(name)]
        if row == words.FRICTION and as_number(slope) != 0.0:
            raise OptionError(f"{what} depends on accelerations; free1 and free2, by the paper's model, are known")
        if any(as_number(definitions.slope(slope, other)) != 0.0 for other in words.ACCELERATIONS):
            raise OptionError(f"{what} is not linear in the accelerations, so that no equation of motion follows")


def _body(needed: Mapping[str, Tree], results: Iterable[Tree], inputs: Mapping[str, str]) -> list[str]:
    """Return the lines that compute what results are made of, which need some definitions."""
    used = set[str]().union(*(names_in(tree) for tree in (*results, *needed.values())))
    lines = [f"{name} = {text}" for name, text in inputs.items() if name in used]
    return lines + [f"{name} = {ast.unparse(tree)}" for name, tree in needed.items()]


def _function(name: str, arguments: str, doc: str, lines: Sequence[str]) -> str:
    body = "".join(f"    {line}\n" for line in lines)
    return f'def {name}({arguments}):\n    """{doc}"""\n{body}'


def paper_text() -> str:
    """Return the function of the paper's torques without inertia, and its inertia beside the diagonal; its slopes."""
    definitions = Definitions("the equations of motion")
    left = [definitions.value("torque", text) for text in words.PAPER]
    inertia = negative(definitions.slope(left[0], "alpha2"))
    results, needed = definitions.given(dict(enumerate((*left, inertia))), dict.fromkeys(("alpha1", "alpha2"), 0))
    lines = [f"{', '.join(names)} = {given}" for given, names in _PAPER_INPUTS.items()]
    lines += _body(needed, results.values(), {})
    lines.append(f"return {', '.join(map(ast.unparse, results.values()))}")
    doc = "Torques on the rods, and the inertia between them."
    pushes = _function("pushes", f"u, {', '.join(_PAPER_INPUTS)}", doc, lines)
    return f"{pushes}\n\n{_law('slopes_of_paper', _PAPER, rows_of(_PAPER), False)}"
