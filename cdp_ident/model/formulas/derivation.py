# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas with their derivatives, as a list of definitions that compiled code computes one after the other.

Each definition is short, and each derivative is that of a definition by those before it (forward differentiation:
Griewank and Walther, Evaluating Derivatives, 2008), so that nothing grows and the code can be read. Needs sympy, which
only making code does.
"""

import ast
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias, TypeVar

import numpy as np
import sympy

from cdp_ident.errors import OptionError
from cdp_ident.model.formulas.language import DERIVED, FREE, FUNCTIONS, GIVEN, OF_JOINT, OPERATORS, PAPER, VARIABLES
from cdp_ident.model.formulas.syntax import Tree, parse

Symbol: TypeAlias = Any
Expression: TypeAlias = Any
"""Of sympy, which has no types."""
Key = TypeVar("Key")

_FUNCTIONS = {
    "sin": sympy.sin, "cos": sympy.cos, "tan": sympy.tan, "atan": sympy.atan, "tanh": sympy.tanh, "exp": sympy.exp,
    "log": sympy.log, "sqrt": sympy.sqrt, "abs": sympy.Abs, "sign": sympy.sign,
    "step": lambda x: sympy.Heaviside(x, 1),
}  # fmt: skip
assert tuple(_FUNCTIONS) == FUNCTIONS
_POINTS = 4
"""Points of a mean: Gauss and Legendre's rule is exact for polynomials of seventh degree."""


def symbol(name: str) -> Symbol:
    """Return a name as a symbol, which is a real number."""
    return sympy.Symbol(name, real=True)


class Definitions:
    """Names with their expressions, in an order in which each uses only those before it."""

    def __init__(self, where: str, joint: str = "") -> None:
        """Begin with what every formula may use; `joint` is that of the law, `where` is for messages."""
        self._where = where
        self._texts = {**DERIVED, **OF_JOINT.get(joint, {})}
        self._inputs = {symbol(name) for name in (*VARIABLES, *GIVEN)}
        self._of: dict[Symbol, Expression] = {}
        self._slopes: dict[tuple[Symbol, Symbol], Expression] = {}
        self._rates: dict[Symbol, Expression] = {}
        self._theta1, self._theta2 = symbol("theta1"), symbol("theta2")
        s1, c1, s2, c2, s12, c12 = (symbol(name) for name in ("sin1", "cos1", "sin2", "cos2", "sin12", "cos12"))
        self._circular: dict[Symbol, dict[Symbol, Expression]] = {
            s1: {self._theta1: c1}, c1: {self._theta1: -s1}, s2: {self._theta2: c2}, c2: {self._theta2: -s2},
            s12: {self._theta1: c12, self._theta2: -c12}, c12: {self._theta1: -s12, self._theta2: s12},
        }  # fmt: skip
        self._names = {name: symbol(name) for name in (*VARIABLES, *GIVEN)}
        if joint in OF_JOINT:
            self._names["direction"] = symbol(f"direction_{joint}")
        self._names["pi"] = sympy.pi
        self._by_function: dict[Expression, Symbol] = {}

    @property
    def names(self) -> set[str]:
        """The names that a formula may use so far."""
        return {*self._names, *self._texts, *FREE}

    def add_input(self, name: str, stands_for: str = "") -> None:
        """Let formulas use one more input, by another name if it has one."""
        self._names[name] = symbol(stands_for or name)
        self._inputs.add(self._names[name])

    def add(self, name: str, text: str) -> None:
        """Let formulas use a name that stands for a formula, which may use the variable of a mean around it."""
        self._texts[name] = text

    def expression(self, what: str, text: str) -> Expression:
        """Return a formula as an expression; `what` it is, is for messages."""
        return self._expression(parse(text, self.names, f"{self._where}: {what}"))

    def value(self, what: str, text: str) -> Expression:
        """Return the same as a definition of its own, named by `what` it is."""
        return self._define(what.replace(" ", "_"), self.expression(what, text))

    def _expression(self, tree: Tree) -> Expression:
        if isinstance(tree, ast.Constant):
            assert isinstance(tree.value, int | float)
            return sympy.Integer(tree.value) if isinstance(tree.value, int) else sympy.Float(tree.value)
        if isinstance(tree, ast.Name):
            return self._named(tree.id)
        if isinstance(tree, ast.UnaryOp):
            operand = self._expression(tree.operand)
            return -operand if isinstance(tree.op, ast.USub) else operand
        if isinstance(tree, ast.BinOp):
            left, right = self._expression(tree.left), self._expression(tree.right)
            if isinstance(tree.op, ast.Pow):
                return left**right
            if isinstance(tree.op, ast.Mult | ast.Div):
                return left * right if isinstance(tree.op, ast.Mult) else left / right
            return left + right if isinstance(tree.op, ast.Add) else left - right
        assert isinstance(tree, ast.Call)
        assert isinstance(tree.func, ast.Name)
        if tree.func.id in OPERATORS:
            return self._mean(*tree.args) if tree.func.id == "mean" else self._rate(self._expression(tree.args[0]))
        return self._function(_FUNCTIONS[tree.func.id](self._expression(tree.args[0])))

    def _named(self, name: str) -> Expression:
        if name in FREE and name not in self._names:
            self._add_free_motion()
        if name not in self._names:
            self._names[name] = self._define(name, self._expression(parse(self._texts[name], self.names, name)))
        return self._names[name]

    def _function(self, value: Expression) -> Expression:
        """Return a function's value as a name of its own; that of an angle of the rods has one already."""
        if not isinstance(value, sympy.Function):
            return value
        angle, circular = value.args[0], isinstance(value, sympy.sin | sympy.cos)
        if circular and angle in (self._theta1, self._theta2):
            return symbol(f"{value.func.__name__}{1 if angle == self._theta1 else 2}")
        if circular and angle == self._theta1 - self._theta2:
            return self._between_rods(value.func.__name__)
        if value not in self._by_function:
            name = f"{type(value).__name__.lower()}_{len(self._by_function) + 1}"
            self._by_function[value] = self._define(name, value)
        return self._by_function[value]

    def _between_rods(self, name: str) -> Expression:
        """Return sine or cosine of theta1 - theta2, by those of both angles."""
        s12, c12 = symbol("sin12"), symbol("cos12")
        if s12 not in self._of:
            (s1, c1), (s2, c2) = ((symbol(f"sin{k}"), symbol(f"cos{k}")) for k in "12")
            self._of |= {s12: s1 * c2 - c1 * s2, c12: c1 * c2 + s1 * s2}
        return s12 if name == "sin" else c12

    def _mean(self, of: Tree, over: Tree) -> Expression:
        assert isinstance(over, ast.Name)
        before, total = self._names, sympy.Integer(0)
        for place, weight in zip(*np.polynomial.legendre.leggauss(_POINTS), strict=True):
            self._names = {**before, over.id: sympy.Float(0.5 * (place + 1.0))}
            total += sympy.Float(0.5 * weight) * self._expression(of)
        self._names = before
        return total

    def _rate(self, expression: Expression) -> Expression:
        """Return the rate of change along the motion of the paper's model."""
        total = sympy.Integer(0)
        for part in sorted(expression.free_symbols, key=lambda one: one.name):
            total += _smooth(sympy.diff(expression, part)) * self._rate_of(part)
        return total

    def _rate_of(self, part: Symbol) -> Expression:
        if part not in self._rates:
            rates = {"theta1": "omega1", "theta2": "omega2", "omega1": "free1", "omega2": "free2"}
            if part.name == "t":
                self._rates[part] = sympy.Integer(1)
            elif part.name in rates:
                self._rates[part] = self._named(rates[part.name])
            elif part in self._circular:
                self._rates[part] = sum(
                    (slope * self._rate_of(angle) for angle, slope in self._circular[part].items()), sympy.Integer(0)
                )
            elif part in self._of:
                self._rates[part] = self._define(f"{part.name}_rate", self._rate(self._of[part]))
            else:
                self._rates[part] = sympy.Integer(0)
        return self._rates[part]

    def _add_free_motion(self) -> None:
        """Define the accelerations of the paper's model, its cart at rest, from the equations of motion."""
        alphas = [symbol(name) for name in ("alpha1", "alpha2")]
        still = dict.fromkeys(alphas, 0) | {symbol("u"): 0}
        left = [self._expression(parse(text, self.names, "the equations of motion")) for text in PAPER]
        n1, n2 = (self._define(f"push{k}", part.subs(still)) for k, part in enumerate(left, start=1))
        m, inertia = self._define("m", -sympy.diff(left[0], alphas[1])), -sympy.diff(left[1], alphas[1])
        inverse = self._define("inverse", 1 / (inertia - m**2))
        self._names["free1"] = self._define("free1", inverse * (inertia * n1 - m * n2))
        self._names["free2"] = self._define("free2", inverse * (n2 - m * n1))

    def _define(self, name: str, expression: Expression) -> Expression:
        """Return a new name for an expression, or itself where it is one name or number already."""
        if expression.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo, sympy.I):
            what = name.replace("_", " ")
            raise OptionError(f"{self._where}: {what} is no number for any motion: what is divided by?")
        if expression.is_Number or expression.is_Symbol or (-expression).is_Symbol:
            return expression
        new = symbol(name)
        while new in self._of or new in self._inputs:
            new = symbol(f"{new.name}_")
        self._of[new] = expression
        return new

    def slope(self, expression: Expression, by: Symbol) -> Expression:
        """Return the derivative of an expression; those of definitions become definitions themselves."""
        total = sympy.Integer(0)
        for part in sorted(expression.free_symbols, key=lambda one: one.name):
            inner = self._slope_of(part, by)
            if inner != 0:
                total += _smooth(sympy.diff(expression, part)) * inner
        return total

    def _slope_of(self, part: Symbol, by: Symbol) -> Expression:
        if part == by:
            return sympy.Integer(1)
        if part in self._circular:
            return self._circular[part].get(by, sympy.Integer(0))
        if (part, by) not in self._slopes:
            slope = self.slope(self._of[part], by) if part in self._of else sympy.Integer(0)
            slope = sum((self._without_calls(term) for term in sympy.Add.make_args(slope)), start=sympy.Integer(0))
            self._slopes[part, by] = self._define(f"{part.name}_by_{by.name}", slope)
        return self._slopes[part, by]

    def _without_calls(self, expression: Expression) -> Expression:
        """Return an expression with calls of functions replaced by their names, where these have one."""
        return expression.xreplace(self._by_function)

    def needed(self, results: Iterable[Expression]) -> dict[Symbol, Expression]:
        """Return the definitions that some results need, in their order."""
        return _needed(self._of, results)

    def given(
        self, results: Mapping[Key, Expression], values: Mapping[Symbol, int]
    ) -> tuple[dict[Key, Expression], dict[Symbol, Expression]]:
        """Return results where some names have given values, and the definitions that they then need."""
        known: dict[Symbol, Expression] = {name: sympy.Integer(value) for name, value in values.items()}
        remaining: dict[Symbol, Expression] = {}
        for name, expression in self.needed(results.values()).items():
            simpler = expression.xreplace(known)
            (known if simpler.is_Number else remaining)[name] = simpler
        found = {key: expression.xreplace(known) for key, expression in results.items()}
        return found, _needed(remaining, found.values())


def _needed(definitions: Mapping[Symbol, Expression], results: Iterable[Expression]) -> dict[Symbol, Expression]:
    wanted: set[Symbol] = set()
    missing = {s for result in results for s in result.free_symbols}
    while missing:
        one = missing.pop()
        if one in definitions and one not in wanted:
            wanted.add(one)
            missing |= definitions[one].free_symbols
    return {name: expression for name, expression in definitions.items() if name in wanted}


def _smooth(expression: Expression) -> Expression:
    """Return a derivative without the impulses where an absolute value, a sign or a step has its kink."""
    return expression.replace(sympy.DiracDelta, lambda *_: sympy.Integer(0))
