# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws as Python code for the compiler, made of their formulas: readable, and without a derivative that is zero.

A law's function takes the inputs (see `language.INPUTS`), its parameters, sums of all laws to add to, and rows of its
own to fill in. What it adds to torques and to the cart's acceleration, and the derivatives of that by what all laws
share, goes to the sums; derivatives by its own states and parameters, and everything else, to its rows. What is always
zero is left out.
"""

import re
from collections.abc import Iterable, Mapping, Sequence

import sympy
from sympy.printing.pycode import PythonCodePrinter

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.effect import Effect, Law
from cdp_ident.model.formulas import language as words
from cdp_ident.model.formulas.derivation import Definitions, Expression, Symbol, symbol

_HEADER = '''# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Made of the laws' formulas when the package is built, by `formulas/generated.py`; not by hand."""

from math import atan, cos, exp, log, sin, sqrt, tan, tanh, pi

DIGEST = "{digest}"
"""Of what it was made of."""
'''
_PAPER_INPUTS = ("sin1", "cos1", "sin2", "cos2", "omega1", "omega2", "u", *words.COEFFICIENTS)
_PAPER = Effect("equations of motion", "base", "", Law(torques=words.PAPER), (), "the paper")
"""What is left of them, as a law."""


class _Printer(PythonCodePrinter):  # type: ignore[misc]  # sympy has no types
    def __init__(self) -> None:
        super().__init__({"fully_qualified_modules": False})

    def _print_Abs(self, expression: Expression) -> str:  # noqa: N802 - as sympy calls them
        return f"abs({self._print(expression.args[0])})"

    def _print_sign(self, expression: Expression) -> str:
        of = self._print(expression.args[0])
        return f"((1.0 if {of} > 0.0 else 0.0) - (1.0 if {of} < 0.0 else 0.0))"

    def _print_Heaviside(self, expression: Expression) -> str:  # noqa: N802
        return f"(1.0 if {self._print(expression.args[0])} >= 0.0 else 0.0)"

    def _print_Integer(self, expression: Expression) -> str:  # noqa: N802 - in floating point
        return f"{int(expression)}.0"

    def _print_Rational(self, expression: Expression) -> str:  # noqa: N802
        return f"({expression.p}.0/{expression.q}.0)"

    def _print_Pow(self, expression: Expression, **_: object) -> str:  # noqa: N802
        base, power = expression.args
        if power.is_Integer and 2 <= abs(power) <= 4:
            text = "*".join([self.parenthesize(base, 50)] * abs(int(power)))
            return f"({text})" if power > 0 else f"(1.0/({text}))"
        return super()._print_Pow(expression)


_print = _Printer().doprint


def module_text(effects: Sequence[Effect], digest: str, paper: bool) -> str:
    """Return the code of a module with the laws of effects, and with the equations of motion or not."""
    functions, by_text = [_HEADER.format(digest=digest)], dict[tuple[object, ...], str]()
    tables: dict[str, dict[str, str]] = {"MOTION": {}, "MOTION_AT_ZERO": {}, "READING": {}, "READING_AT_ZERO": {}}
    if paper:
        functions += [_pushes(), _law("slopes_of_paper", _PAPER, motion_rows(_PAPER), "MOTION")]
    for effect in effects:
        if effect.curve is not None:
            continue
        rows_of = {"MOTION": motion_rows(effect), "READING": _reading(effect)}
        if effect.known_at_zero:
            rows_of |= {f"{table}_AT_ZERO": rows for table, rows in rows_of.items()}
        for table, rows in rows_of.items():
            same = (table, effect.law, effect.joint, tuple(p.name for p in effect.parameters))
            if rows and same not in by_text:
                parts = effect.name, effect.joint, "" if effect.harmonic else effect.variant, table.lower()
                by_text[same] = re.sub(r"\W", "_", "_".join(filter(None, parts)))
                functions.append(_law(by_text[same], effect, rows, table))
            if rows:
                tables[table][effect.key] = by_text[same]
    functions.append(f"KEYS = {{{', '.join(repr(e.key) for e in effects if e.curve is None)}}}\n")
    for table, names in tables.items():
        lines = "".join(f'    "{key}": {name},\n' for key, name in names.items())
        functions.append(f"{table} = {{\n{lines}}}\n")
    return "\n\n".join(functions)


def motion_rows(effect: Effect) -> Mapping[int, str]:
    """Return the formulas of what a law adds to the motion, by row."""
    law = effect.law
    rows = {words.FRICTION: law.friction, words.CART: law.cart}
    torque = f"-direction*({law.friction})" if law.friction else law.torque
    if torque:
        rows[words.TORQUE1], rows[words.TORQUE2] = (torque, "") if effect.joint == "inner" else (f"-({torque})", torque)
    else:
        rows[words.TORQUE1], rows[words.TORQUE2] = law.torques
    rows |= {words.RATES + k: state.rate for k, state in enumerate(law.states)}
    return {row: rows[row] for row in sorted(rows) if rows[row]}


def _reading(effect: Effect) -> Mapping[int, str]:
    """Return the formulas of what a law adds to readings, by row."""
    law, own = effect.law, words.OUTER if effect.joint == "outer" else words.INNER
    rows = {words.INNER: law.readings[0], words.OUTER: law.readings[1], words.LATENESS: law.lateness}
    if law.reading:
        rows[own] = law.reading
    return {row: text for row, text in rows.items() if text}


_MOTION_ROWS = ("torque on theta1", "torque on theta2", "friction", "cart", "rate 1", "rate 2")
_READING_ROWS = ("inner reading", "outer reading", "lateness")
"""What rows are called, in their order."""


def _law(function: str, effect: Effect, rows: Mapping[int, str], table: str) -> str:
    """Return the function of a law, in one of the tables of laws."""
    at_zero, moves = table.endswith("AT_ZERO"), table.startswith("MOTION")
    definitions = Definitions(f"{effect.name}.{effect.joint}", effect.joint)
    parameters = [symbol(p.name) for p in effect.parameters]
    for p in effect.parameters:
        definitions.add_input(p.name)
    for state, own in zip(effect.law.states, words.OWN, strict=False):
        if at_zero:
            definitions.add(state.name, state.at_zero)
        else:
            definitions.add_input(state.name, own)
    for defined, text in effect.law.where:
        definitions.add(defined, text)
    names = _MOTION_ROWS if moves else _READING_ROWS
    strengths = [symbol(p.name) for p in effect.parameters if not (p.shape or p.fixed)]
    results = dict[tuple[int, int], Expression]()
    for row, text in rows.items():
        if at_zero and moves and row >= words.RATES:
            continue
        value = definitions.value(names[row], text)
        by = [*map(symbol, words.VARIABLES), *parameters]
        slopes = {column: definitions.slope(value, variable) for column, variable in enumerate(by, start=1)}
        if moves and row < words.RATES:
            _refuse_accelerations(definitions, f"{effect.key}: {names[row]}", row, slopes.items())
        if moves and row == words.FRICTION:
            slopes = {}  # its torques have them
        if at_zero:
            slopes = {column: e for column, e in slopes.items() if by[column - 1] in strengths}
        results |= {(row, column): e for column, e in {0: value, **slopes}.items() if column == 0 or e != 0}
    width = words.PARAMETERS + len(parameters)
    inputs = {symbol(n): f"z[{k}]" for k, n in enumerate(words.INPUTS)}
    inputs |= {p: f"p[{k}]" for k, p in enumerate(parameters)}
    columns = ("value", *words.VARIABLES, *(p.name for p in effect.parameters))
    results, needed = definitions.given(results, dict.fromkeys(strengths, 0) if at_zero else {})
    lines = _body(needed, results.values(), inputs)
    for (row, column), expression in results.items():
        if at_zero and expression == 0:
            continue
        what = names[row] if column == 0 else f"{names[row]} by {columns[column]}"
        is_shared = moves and row in words.SUMS and columns[column] not in words.OWN and column < words.PARAMETERS
        of_sums = words.SUMS.index(row) * words.PARAMETERS + column if is_shared else 0
        place = f"sums[{of_sums}] +" if is_shared else f"rows[{row * width + column}] "
        lines.append(f"{place}= {_print(expression)}  # {what}")
    return _function(function, "z, p, sums, rows", effect.formula, lines)


def _refuse_accelerations(
    definitions: Definitions, what: str, row: int, slopes: Iterable[tuple[int, Expression]]
) -> None:
    """Refuse a law that is not linear in the accelerations, or a friction that depends on them at all."""
    by = [symbol(name) for name in words.ACCELERATIONS]
    for column, slope in slopes:
        if words.VARIABLES[column - 1 : column] and words.VARIABLES[column - 1] in words.ACCELERATIONS and slope != 0:
            if row == words.FRICTION:
                raise OptionError(f"{what} depends on accelerations; free1 and free2, by the paper's model, are known")
            if any(definitions.slope(slope, other) != 0 for other in by):
                raise OptionError(f"{what} is not linear in the accelerations, so that no equation of motion follows")


def _body(
    needed: Mapping[Symbol, Expression], results: Iterable[Expression], inputs: Mapping[Symbol, str]
) -> list[str]:
    """Return the lines that compute what results are made of, which need some definitions."""
    results = list(results)
    used = {s for e in (*results, *needed.values()) for s in e.free_symbols}
    lines = [f"{name} = {text}" for name, text in inputs.items() if name in used]
    return lines + [f"{name} = {_print(expression)}" for name, expression in needed.items()]


def _function(name: str, arguments: str, doc: str, lines: Sequence[str]) -> str:
    body = "".join(f"    {line}\n" for line in lines)
    return f'def {name}({arguments}):\n    """{doc}"""\n{body}'


def _pushes() -> str:
    """Return the function of the paper's torques without inertia, and of its inertia beside the diagonal."""
    definitions = Definitions("the equations of motion")
    alphas = [symbol(name) for name in words.ACCELERATIONS[:2]]
    left = [definitions.expression("torque", text) for text in words.PAPER]
    pushes = [part.subs(dict.fromkeys(alphas, 0)) for part in left]
    results = [*pushes, -sympy.diff(left[0], alphas[1])]
    lines = _body(definitions.needed(results), results, {})
    lines.append(f"return {', '.join(map(_print, results))}")
    return _function("pushes", ", ".join(_PAPER_INPUTS), "Torques on the rods, and the inertia between them.", lines)
