# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas as short definitions, one after the other, with their derivatives.

Each derivative is that of a definition by those before it (forward differentiation: Griewank and Walther, Evaluating
Derivatives, 2008), so that nothing grows and the code can be read.
"""

import ast
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

import numpy as np

from cdp_ident.errors import OptionError
from cdp_ident.model.formulas.algebra import (
    Tree,
    applied,
    as_number,
    combined,
    function_of,
    names_in,
    negative,
    number,
    rebuilt,
    substituted,
)
from cdp_ident.model.formulas.language import DERIVED, FREE, GIVEN, OF_JOINT, PAPER, STATE, VARIABLES
from cdp_ident.model.formulas.syntax import levels, parse, tree_of

Key = TypeVar("Key")

_SLOPES = {
    "sin": "cos(x)", "cos": "-sin(x)", "tan": "1 + tan(x)^2", "atan": "1/(1 + x^2)", "tanh": "1 - tanh(x)^2",
    "exp": "exp(x)", "log": "1/x", "sqrt": "1/(2*sqrt(x))", "abs": "sign(x)", "sign": "0", "step": "0",
}  # fmt: skip
"""The derivative of each function, without the impulses where an absolute value, a sign or a step has its kink."""
_CIRCULAR = {
    "sin(theta1)": "sin1", "cos(theta1)": "cos1", "sin(theta2)": "sin2", "cos(theta2)": "cos2",
    "sin(theta1 - theta2)": "sin12", "cos(theta1 - theta2)": "cos12", "sin(theta2 - theta1)": "-sin12",
    "cos(theta2 - theta1)": "cos12", "sin(theta1 - pi)": "-sin1", "cos(theta1 - pi)": "-cos1",
}  # fmt: skip
"""Sines and cosines that have names already."""
_TURNED = {
    "sin1": "cos1*theta1", "cos1": "-sin1*theta1", "sin2": "cos2*theta2", "cos2": "-sin2*theta2",
    "sin12": "cos12*(theta1 - theta2)", "cos12": "-sin12*(theta1 - theta2)",
}  # fmt: skip
"""How each of them changes where the angles do."""
_MOTION = {"theta1": "omega1", "theta2": "omega2", "omega1": "free1", "omega2": "free2", "t": "1"}
"""Rates of change along the motion of the paper's model, its cart at rest."""
_TIME = "time along the motion"
"""What stands for it where others are differentiated by a name."""
_LONG = 12
"""Parts within parts of a formula that is one definition: its derivatives have some times as many."""
_POINTS = 4
"""Points of a mean: Gauss and Legendre's rule is exact for polynomials of seventh degree."""


class Definitions:
    """Names with their formulas, in an order in which each uses only those before it."""

    def __init__(self, where: str, joint: str = "") -> None:
        """Begin with what every formula may use; `joint` is that of the law, `where` is for messages."""
        self._where = where
        self._texts = {**DERIVED, **OF_JOINT.get(joint, {})}
        self._inputs = {*VARIABLES, *GIVEN, "pi"}
        self._of: dict[str, Tree] = {}
        self._slopes: dict[tuple[str, str], Tree] = {}
        self._names: dict[str, Tree] = {name: ast.Name(name) for name in self._inputs}
        if joint in OF_JOINT:
            self._names["direction"] = ast.Name(f"direction_{joint}")
        self._by_function: dict[str, Tree] = {}

    @property
    def names(self) -> set[str]:
        """The names that a formula may use so far."""
        return {*self._names, *self._texts, *FREE}

    def add_input(self, name: str, stands_for: str = "") -> None:
        """Let formulas use one more input, by another name if it has one."""
        self._names[name] = ast.Name(stands_for or name)
        self._inputs.add(stands_for or name)

    def add(self, name: str, text: str) -> None:
        """Let formulas use a name that stands for a formula, which may use the variable of a mean around it."""
        self._texts[name] = text

    def value(self, what: str, text: str) -> Tree:
        """Return a formula as a definition of its own, named by `what` it is."""
        try:
            tree = self._expression(parse(text, self.names, f"{self._where}: {what}"))
        except (ArithmeticError, ValueError):
            raise OptionError(f"{self._where}: {what} is no number for any motion: what is divided by?") from None
        return self._define(what.replace(" ", "_"), tree)

    def _expression(self, tree: Tree) -> Tree:
        """Return a formula in inputs, names of definitions, and numbers; what is long is put together of short ones."""
        if isinstance(tree, ast.BinOp) and levels(tree) > _LONG:
            sides = [self._define("part", self._expression(side)) for side in (tree.left, tree.right)]
            return combined(type(tree.op), *sides)
        return rebuilt(tree, self._named, self._called)

    def _named(self, name: str) -> Tree:
        if name in FREE and name not in self._names:
            self._add_free_motion()
        if name not in self._names:
            self._names[name] = self._define(name, self._expression(parse(self._texts[name], self.names, name)))
        return self._names[name]

    def _called(self, name: str, arguments: Sequence[Tree]) -> Tree:
        if name == "mean":
            return self._mean(*arguments)
        argument = self._expression(arguments[0])
        return self.slope(argument, _TIME) if name == "rate" else self._function(name, argument)

    def _function(self, name: str, argument: Tree) -> Tree:
        """Return a function's value as a name of its own; that of an angle of the rods has one already."""
        tree = applied(name, argument)
        text = ast.unparse(tree)
        if text in _CIRCULAR:
            return self._expression(tree_of(_CIRCULAR[text]))
        if text not in self._by_function:
            self._by_function[text] = self._define(f"{name}_{len(self._by_function) + 1}", tree)
        return self._by_function[text]

    def _put(self, text: str, parts: Mapping[str, Tree]) -> Tree:
        """Return a formula of inputs and of parts that have names in it."""
        return substituted(tree_of(text), parts, self._function)

    def _mean(self, of: Tree, over: Tree) -> Tree:
        assert isinstance(over, ast.Name)
        before, total = self._names, number(0.0)
        for place, weight in zip(*np.polynomial.legendre.leggauss(_POINTS), strict=True):
            self._names = {**before, over.id: number(0.5 * (place + 1.0))}
            part = combined(ast.Mult, number(0.5 * weight), self._expression(of))
            total = combined(ast.Add, total, part)
        self._names = before
        return total

    def _add_free_motion(self) -> None:
        """Define the accelerations of the paper's model, its cart at rest, from the equations of motion."""
        left = [self._expression(tree_of(text)) for text in PAPER]
        still = dict.fromkeys(("alpha1", "alpha2", "u"), number(0.0))
        parts = {
            "push1": substituted(left[0], still), "push2": substituted(left[1], still),
            "m": negative(self.slope(left[0], "alpha2")), "inertia": negative(self.slope(left[1], "alpha2")),
        }  # fmt: skip
        parts = {name: self._define(name, tree) for name, tree in parts.items()}
        parts["determinant"] = self._define("determinant", self._put("inertia - m^2", parts))
        for name, text in (
            ("free1", "(inertia*push1 - m*push2)/determinant"),
            ("free2", "(push2 - m*push1)/determinant"),
        ):
            self._names[name] = self._define(name, self._put(text, parts))

    def _define(self, name: str, tree: Tree) -> Tree:
        """Return a new name for a tree, or itself where it is one name or number already."""
        if as_number(tree) is not None or isinstance(tree, ast.Name) or isinstance(negative(tree), ast.Name):
            return tree
        while name in self._of or name in self._inputs:
            name += "_"
        self._of[name] = tree
        return ast.Name(name)

    def slope(self, tree: Tree, by: str, name: Tree | None = None) -> Tree:
        """Return the derivative of a tree, which may have a name; those of definitions become definitions, too."""
        if isinstance(tree, ast.Name):
            return self._slope_of(tree.id, by)
        if isinstance(tree, ast.UnaryOp):
            return negative(self.slope(tree.operand, by))
        if isinstance(tree, ast.Call):
            (argument,) = tree.args
            inner = self.slope(argument, by)
            if as_number(inner) == 0.0:
                return inner
            return combined(ast.Mult, self._put(_SLOPES[function_of(tree)], {"x": argument}), inner)
        if not isinstance(tree, ast.BinOp):
            return number(0.0)
        parts = {"f": tree.left, "g": tree.right, "f_": self.slope(tree.left, by), "g_": self.slope(tree.right, by)}
        parts["it"] = name or tree
        power = isinstance(tree.op, ast.Pow) and as_number(parts["g_"]) == 0.0
        return self._put("g*f^(g - 1)*f_" if power else _RULES[type(tree.op)], parts)

    def _slope_of(self, name: str, by: str) -> Tree:
        if name == by:
            return number(1.0)
        if by == _TIME and name in _MOTION:
            return self._expression(tree_of(_MOTION[name]))
        if (name, by) not in self._slopes:
            if name in _TURNED:
                known = {word: self._named(word) for word in names_in(tree_of(_TURNED[name]))}
                slope = self._put(_TURNED[name], known | {angle: self._slope_of(angle, by) for angle in STATE[:2]})
            else:
                slope = self.slope(self._of[name], by, ast.Name(name)) if name in self._of else number(0.0)
            new = f"{name}_rate" if by == _TIME else f"{name}_by_{by}"
            self._slopes[name, by] = slope if name in _TURNED else self._define(new, slope)
        return self._slopes[name, by]

    def needed(self, results: Iterable[Tree]) -> dict[str, Tree]:
        """Return the definitions that some results need, in their order."""
        return _needed(self._of, results)

    def given(self, results: Mapping[Key, Tree], values: Mapping[str, int]) -> tuple[dict[Key, Tree], dict[str, Tree]]:
        """Return results where some names have given values, and the definitions that they then need."""
        known = {name: number(value) for name, value in values.items()}
        remaining: dict[str, Tree] = {}
        for name, tree in self.needed(results.values()).items():
            simpler = substituted(tree, known)
            (remaining if as_number(simpler) is None else known)[name] = simpler
        found = {key: substituted(tree, known) for key, tree in results.items()}
        return found, _needed(remaining, found.values())


_RULES = {
    ast.Add: "f_ + g_", ast.Sub: "f_ - g_", ast.Mult: "f_*g + f*g_", ast.Div: "(f_ - it*g_)/g",
    ast.Pow: "it*(g_*log(f) + g*f_/f)",
}  # fmt: skip
"""The derivative of each operation of f and g, whose derivatives are f_ and g_; `it` is what becomes of them."""


def _needed(definitions: Mapping[str, Tree], results: Iterable[Tree]) -> dict[str, Tree]:
    wanted: set[str] = set()
    missing = {name for result in results for name in names_in(result)}
    while missing:
        one = missing.pop()
        if one in definitions and one not in wanted:
            wanted.add(one)
            missing |= names_in(definitions[one])
    return {name: tree for name, tree in definitions.items() if name in wanted}
