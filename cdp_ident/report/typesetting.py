"""Formulas of laws, typeset from their syntax: as MathML for a page, and as LaTeX for documents."""

import ast
import html
import re
from dataclasses import dataclass

from cdp_ident.errors import OptionError
from cdp_ident.model.formulas.syntax import Tree, names_used, parse

_GREEK = {"theta": "θ", "omega": "ω", "alpha": "α", "pi": "π"}
_OF_JOINT = ("angle", "speed", "acceleration")
_NUMBERED = re.compile(r"([A-Za-z]+?)_?(\d+)")
_SUM, _PRODUCT, _POWER, _ALONE = range(4)
"""How closely the parts of an expression belong together."""


@dataclass(frozen=True)
class _Notation:
    """How things are written; `{}` is where parts go."""

    row: str
    fraction: str
    power: str
    below: str
    root: str
    absolute: str
    brackets: str
    function: str
    symbol: str
    word: str
    number: str
    rates: tuple[str, str, str]
    """A joint's angle, speed and acceleration."""
    prime: str
    """A rate of change."""
    times: str
    minus: str
    plus: str
    equals: str
    comma: str
    greek: dict[str, str]


_MATHML = _Notation(
    row="<mrow>{}</mrow>",
    fraction="<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>",
    power="<msup><mrow>{}</mrow><mrow>{}</mrow></msup>",
    below="<msub>{}<mn>{}</mn></msub>",
    root="<msqrt>{}</msqrt>",
    absolute="<mrow><mo>|</mo>{}<mo>|</mo></mrow>",
    brackets="<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
    function="<mrow><mi>{}</mi><mo>&#x2061;</mo><mo>(</mo>{}<mo>)</mo></mrow>",
    symbol="<mi>{}</mi>",
    word="<mi mathvariant='normal'>{}</mi>",
    number="<mn>{}</mn>",
    rates=("<mi>φ</mi>", "<mi>φ̇</mi>", "<mi>φ̈</mi>"),
    prime="<msup>{}<mo>′</mo></msup>",
    times="<mo>&#x2009;</mo>",
    minus="<mo>−</mo>",
    plus="<mo>+</mo>",
    equals="<mo>=</mo>",
    comma="<mo>,</mo>",
    greek={letter: letter for letter in "θωαπ"},
)
_LATEX = _Notation(
    row="{}",
    fraction=r"\frac{{{}}}{{{}}}",
    power="{{{}}}^{{{}}}",
    below="{}_{{{}}}",
    root=r"\sqrt{{{}}}",
    absolute=r"\lvert {} \rvert",
    brackets=r"\left({}\right)",
    function=r"\operatorname{{{}}}\left({}\right)",
    symbol="{}",
    word=r"\mathrm{{{}}}",
    number="{}",
    rates=(r"\varphi ", r"\dot{\varphi }", r"\ddot{\varphi }"),
    prime="{}'",
    times=r"\,",
    minus="-",
    plus="+",
    equals="=",
    comma=", ",
    greek={"θ": r"\theta ", "ω": r"\omega ", "α": r"\alpha ", "π": r"\pi "},
)


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


def _typeset(text: str, notation: _Notation) -> list[str] | None:
    """Return the lines of a law's formulas; None where it has none."""
    lines = []
    for line in text.split("; "):
        what, _, formula = line.partition(" = ")
        try:
            tree = parse(formula, names_used([formula]), "")
        except (OptionError, SyntaxError, ValueError):
            return None
        writer, state = _Writer(notation), what.removesuffix("'")
        left = writer.name(state) if state.isidentifier() else writer.words(what)
        left = left if state == what else notation.prime.format(left)
        lines.append(notation.row.format(f"{left}{notation.equals}{writer.of(tree)}"))
    return lines


class _Writer:
    def __init__(self, notation: _Notation) -> None:
        self._notation = notation

    def of(self, tree: Tree, within: int = _SUM) -> str:
        """Return an expression; in brackets where it belongs together less closely than what it is within."""
        written, closely = self._written(tree)
        return written if closely >= within else self._notation.brackets.format(written)

    def _written(self, tree: Tree) -> tuple[str, int]:
        n = self._notation
        if isinstance(tree, ast.Constant):
            return self._number(str(tree.value)), _ALONE
        if isinstance(tree, ast.Name):
            return self.name(tree.id), _ALONE
        if isinstance(tree, ast.UnaryOp):
            sign = n.minus if isinstance(tree.op, ast.USub) else ""
            return f"{sign}{self.of(tree.operand, _PRODUCT)}", _SUM
        if isinstance(tree, ast.Call):
            return self._call(tree)
        assert isinstance(tree, ast.BinOp)
        if isinstance(tree.op, ast.Div):
            return n.fraction.format(self.of(tree.left), self.of(tree.right)), _PRODUCT
        if isinstance(tree.op, ast.Pow):
            return n.power.format(self.of(tree.left, _ALONE), self.of(tree.right)), _POWER
        if isinstance(tree.op, ast.Mult):
            first = _SUM if isinstance(tree.left, ast.UnaryOp) else _PRODUCT
            return f"{self.of(tree.left, first)}{n.times}{self.of(tree.right, _PRODUCT)}", _PRODUCT
        sign = n.plus if isinstance(tree.op, ast.Add) else n.minus
        return f"{self.of(tree.left)}{sign}{self.of(tree.right, _PRODUCT)}", _SUM

    def _call(self, tree: ast.Call) -> tuple[str, int]:
        assert isinstance(tree.func, ast.Name)
        n, name, inside = self._notation, tree.func.id, [self.of(argument) for argument in tree.args]
        if name in ("sqrt", "abs"):
            return (n.root if name == "sqrt" else n.absolute).format(*inside), _ALONE
        if name == "exp":
            return n.power.format(n.symbol.format("e"), *inside), _POWER
        return n.function.format(name, n.comma.join(inside)), _ALONE

    def _number(self, text: str) -> str:
        n = self._notation
        digits, _, exponent = text.partition("e")
        if not exponent:
            return n.number.format(digits)
        power = n.power.format(n.number.format("10"), n.number.format(f"{int(exponent)}"))
        return power if digits == "1" else f"{n.number.format(digits)}{n.times}{power}"

    def name(self, name: str) -> str:
        """Return a name: as the field's symbol where it has one."""
        n = self._notation
        if name in _OF_JOINT:
            return n.rates[_OF_JOINT.index(name)]
        if name == "direction":
            return n.function.format("sgn", n.rates[1])
        if name == "m2_l2":
            return f"{self.name('m2')}{n.times}{self.name('l2')}"
        if name in _GREEK:
            return n.symbol.format(n.greek[_GREEK[name]])
        if numbered := _NUMBERED.fullmatch(name):
            return n.below.format(self.name(numbered[1]), numbered[2])
        return n.symbol.format(name) if len(name) == 1 else self.words(name)

    def words(self, text: str) -> str:
        """Return words, in upright letters."""
        is_latex = self._notation is _LATEX
        text = text.replace("_", " ") if is_latex else html.escape(text.replace("_", " "))
        return self._notation.word.format(text.replace(" ", r"\ " if is_latex else "&#xa0;"))
