# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas of laws, typeset from their syntax: as MathML for a page, and as LaTeX for documents."""

import ast
import html
import re

from cdp_ident.errors import OptionError
from cdp_ident.model.formulas.algebra import Tree
from cdp_ident.model.formulas.syntax import names_used, parse

_GREEK = {"theta": "θ", "omega": "ω", "alpha": "α", "pi": "π"}
_NUMBERED = re.compile(r"([A-Za-z]+?)_?(\d+)")
_SUM, _PRODUCT, _POWER, _ALONE = range(4)
"""How closely the parts of an expression belong together."""
_MATHML, _LATEX = range(2)
_NOTATION = {
    "row": ("<mrow>{}</mrow>", "{}"),
    "fraction": ("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", r"\frac{{{}}}{{{}}}"),
    "power": ("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", "{{{}}}^{{{}}}"),
    "below": ("<msub>{}<mn>{}</mn></msub>", "{}_{{{}}}"),
    "sqrt": ("<msqrt>{}</msqrt>", r"\sqrt{{{}}}"),
    "abs": ("<mrow><mo>|</mo>{}<mo>|</mo></mrow>", r"\lvert {} \rvert"),
    "brackets": ("<mrow><mo>(</mo>{}<mo>)</mo></mrow>", r"\left({}\right)"),
    "function": (
        "<mrow><mi>{}</mi><mo>&#x2061;</mo><mo>(</mo>{}<mo>)</mo></mrow>",
        r"\operatorname{{{}}}\left({}\right)",
    ),
    "symbol": ("<mi>{}</mi>", "{}"),
    "word": ("<mi mathvariant='normal'>{}</mi>", r"\mathrm{{{}}}"),
    "number": ("<mn>{}</mn>", "{}"),
    "angle": ("<mi>φ</mi>", r"\varphi "),
    "speed": ("<mi>φ̇</mi>", r"\dot{{\varphi }}"),
    "acceleration": ("<mi>φ̈</mi>", r"\ddot{{\varphi }}"),
    "prime": ("<msup>{}<mo>′</mo></msup>", "{}'"),
    "times": ("<mo>&#x2009;</mo>", r"\,"),
    "minus": ("<mo>−</mo>", "-"),
    "plus": ("<mo>+</mo>", "+"),
    "equals": ("<mo>=</mo>", "="),
    "comma": ("<mo>,</mo>", ", "),
}
"""How things are written in MathML and in LaTeX; `{}` is where parts go."""


class Formula(str):
    """A law in one line, `what = formula; …`, which a page shows typeset."""

    __slots__ = ()

    def __html__(self) -> str:
        """Return it as HTML; as plain text where it is no formula."""
        lines = _typeset(self, _MATHML)
        if lines is None:
            return html.escape(self)
        return "<br>".join(f'<math displaystyle="true">{line}</math>' for line in lines)

    @property
    def latex(self) -> str:
        """It in LaTeX, for documents; as plain text where it is no formula."""
        lines = _typeset(self, _LATEX)
        return str(self) if lines is None else "; ".join(f"${line}$" for line in lines)


def _typeset(text: str, form: int) -> list[str] | None:
    """Return the lines of a law's formulas; None where it has none."""
    lines = []
    for line in text.split("; "):
        what, _, formula = line.partition(" = ")
        try:
            tree = parse(formula, names_used([formula]), "")
        except (OptionError, SyntaxError, ValueError):
            return None
        writer, state = _Writer(form), what.removesuffix("'")
        left = writer.name(state) if state.isidentifier() else writer.words(what)
        left = left if state == what else writer.put("prime", left)
        lines.append(writer.put("row", f"{left}{writer.put('equals')}{writer.of(tree)}"))
    return lines


class _Writer:
    def __init__(self, form: int) -> None:
        self._form = form

    def put(self, thing: str, *parts: str) -> str:
        """Return how something is written, with its parts."""
        return _NOTATION[thing][self._form].format(*parts)

    def of(self, tree: Tree, within: int = _SUM) -> str:
        """Return an expression; in brackets where it belongs together less closely than what it is within."""
        written, closely = self._written(tree)
        return written if closely >= within else self.put("brackets", written)

    def _written(self, tree: Tree) -> tuple[str, int]:
        if isinstance(tree, ast.Constant):
            return self._number(str(tree.value)), _ALONE
        if isinstance(tree, ast.Name):
            return self.name(tree.id), _ALONE
        if isinstance(tree, ast.UnaryOp):
            sign = self.put("minus") if isinstance(tree.op, ast.USub) else ""
            return f"{sign}{self.of(tree.operand, _PRODUCT)}", _SUM
        if isinstance(tree, ast.Call):
            return self._call(tree)
        assert isinstance(tree, ast.BinOp)
        if isinstance(tree.op, ast.Div):
            return self.put("fraction", self.of(tree.left), self.of(tree.right)), _PRODUCT
        if isinstance(tree.op, ast.Pow):
            return self.put("power", self.of(tree.left, _ALONE), self.of(tree.right)), _POWER
        if isinstance(tree.op, ast.Mult):
            first = _SUM if isinstance(tree.left, ast.UnaryOp) else _PRODUCT
            return f"{self.of(tree.left, first)}{self.put('times')}{self.of(tree.right, _PRODUCT)}", _PRODUCT
        sign = self.put("plus" if isinstance(tree.op, ast.Add) else "minus")
        return f"{self.of(tree.left)}{sign}{self.of(tree.right, _PRODUCT)}", _SUM

    def _call(self, tree: ast.Call) -> tuple[str, int]:
        assert isinstance(tree.func, ast.Name)
        name, inside = tree.func.id, [self.of(argument) for argument in tree.args]
        if name in ("sqrt", "abs"):
            return self.put(name, *inside), _ALONE
        if name == "exp":
            return self.put("power", self.put("symbol", "e"), *inside), _POWER
        return self.put("function", name, self.put("comma").join(inside)), _ALONE

    def _number(self, text: str) -> str:
        digits, _, exponent = text.partition("e")
        if not exponent:
            return self.put("number", digits)
        power = self.put("power", self.put("number", "10"), self.put("number", f"{int(exponent)}"))
        return power if digits == "1" else f"{self.put('number', digits)}{self.put('times')}{power}"

    def name(self, name: str) -> str:
        """Return a name: as the field's symbol where it has one."""
        if name in ("angle", "speed", "acceleration"):
            return self.put(name)
        if name == "direction":
            return self.put("function", "sgn", self.put("speed"))
        if name == "m2_l2":
            return f"{self.name('m2')}{self.put('times')}{self.name('l2')}"
        if name in _GREEK:
            return self.put("symbol", f"\\{name} " if self._form == _LATEX else _GREEK[name])
        if numbered := _NUMBERED.fullmatch(name):
            return self.put("below", self.name(numbered[1]), numbered[2])
        return self.put("symbol", name) if len(name) == 1 else self.words(name)

    def words(self, text: str) -> str:
        """Return words, in upright letters."""
        is_latex = self._form == _LATEX
        text = text.replace("_", " ") if is_latex else html.escape(text.replace("_", " "))
        return self.put("word", text.replace(" ", r"\ " if is_latex else "&#xa0;"))
