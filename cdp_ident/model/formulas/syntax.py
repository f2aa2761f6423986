# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A formula's text, checked against the words of the language; nothing of it is ever evaluated."""

import ast
import difflib
import math
import threading
from collections.abc import Collection, Iterable, Mapping
from itertools import accumulate

from cdp_ident.errors import OptionError
from cdp_ident.model.formulas.algebra import (
    FUNCTIONS,
    OPERATIONS,
    Tree,
    as_number,
    function_of,
    names_in,
    number,
    substituted,
)
from cdp_ident.model.formulas.language import OPERATORS

_LONGEST = 2000
"""Characters of a formula, at most."""
_DEEPEST = 60
"""Brackets in brackets, at most."""
_MOST_LEVELS = 200
"""Parts within parts, as sums are of what is summed before, at most."""
_NO_SIGNS = "#\\`@$!?;:\"'{}"
_ONE_AT_A_TIME = threading.Lock()
"""Python's parser fails where two threads use it at once: github.com/python/cpython/issues/106905."""
_LARGEST = 1e15
"""No number is larger."""
_MOST_WITHIN = {"mean": 1, "rate": 2}
"""Operators within each other, at most: each makes a formula several times as long."""


def parse(text: str, names: Collection[str], where: str) -> Tree:
    """Return the syntax tree of a formula.

    Raises `OptionError` where it is none in these names; `where` says what it is, and the message points at the place.
    """
    if not isinstance(text, str) or not text.strip():
        raise OptionError(f"{where}: expected a formula, found {text!r}")
    if len(text) > _LONGEST:
        raise OptionError(f"{where}: a formula of {len(text)} characters; at most {_LONGEST} are read")
    text = " ".join(text.split())
    strange = next((place for place, sign in enumerate(text) if not (" " <= sign <= "~") or sign in _NO_SIGNS), None)
    if strange is not None:
        raise _at(where, text, strange, "only letters, digits and the signs of arithmetic are read")
    if _depth(text) > _DEEPEST:
        raise OptionError(f"{where}: more than {_DEEPEST} brackets in each other")
    try:
        tree = tree_of(text)
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        place = _place(text, (getattr(error, "offset", None) or 1) - 1)
        raise _at(where, text, place, "this is no formula") from None
    if levels(tree) > _MOST_LEVELS:
        raise OptionError(f"{where}: the formula has too many parts in each other: over {_MOST_LEVELS}")
    _Check(names, where, text).visit(tree)
    return tree


def tree_of(text: str) -> Tree:
    """Return the syntax tree of a formula that has passed `parse`, or that is our own."""
    with _ONE_AT_A_TIME:
        return ast.parse(" ".join(text.split()).replace("^", "**"), mode="eval").body


def _depth(text: str) -> int:
    """Return how many brackets are in each other at most."""
    steps = [(character in "([{") - (character in ")]}") for character in text]
    return max(accumulate(steps, initial=0))


def levels(tree: Tree) -> int:
    """Return how many parts are in each other."""
    levels, nodes = 0, list[ast.AST]([tree])
    while nodes:
        levels, nodes = levels + 1, [part for node in nodes for part in ast.iter_child_nodes(node)]
    return levels


def _place(text: str, place: int) -> int:
    """Return the place in a formula of one in it with its powers written as Python does."""
    for index, character in enumerate(text):
        if place <= 0:
            return index
        place -= 2 if character == "^" else 1
    return len(text)


def error_at(where: str, text: str, node: ast.AST, problem: str) -> OptionError:
    """Return the error for a problem with a part of a formula."""
    return _at(where, text, _place(text, getattr(node, "col_offset", 0)), problem)


def _at(where: str, text: str, place: int, problem: str) -> OptionError:
    """Return the error for a problem at a place of a formula, with what stands before it and there."""
    around = f"{text[max(0, place - 25) : place]}>>>{text[place : place + 25]}"
    return OptionError(f"{where}: {problem}; at character {place + 1}: {around.strip()}")


class _Check(ast.NodeVisitor):
    """Refuses whatever is no arithmetic of known names."""

    def __init__(self, names: Collection[str], where: str, text: str) -> None:
        self._names, self._where, self._text = set(names), where, text

    def generic_visit(self, node: ast.AST) -> None:
        raise self._error(node, "this is no arithmetic")

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not isinstance(node.op, tuple(OPERATIONS)):
            raise self._error(node, f"the operator {type(node.op).__name__} is not known; + - * / ^ are")
        self.visit(node.left)
        self.visit(node.right)
        self._check_number(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise self._error(node, "this is no arithmetic")
        self.visit(node.operand)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool) or not isinstance(node.value, int | float):
            raise self._error(node, f"{node.value!r} is no number")
        if not abs(node.value) < _LARGEST:
            raise self._error(node, "this number is too large")

    def visit_Name(self, node: ast.Name) -> None:
        if node.id not in self._names:
            raise self._error(node, f"{node.id} is not known{_nearest(node.id, self._names)}")

    def visit_Call(self, node: ast.Call) -> None:
        name = function_of(node)
        if name not in (*FUNCTIONS, *OPERATORS):
            known = {*FUNCTIONS, *OPERATORS}
            raise self._error(node, f"the function {name or 'here'} is not known{_nearest(name, known)}")
        expected = 2 if name == "mean" else 1
        if node.keywords or len(node.args) != expected or any(isinstance(a, ast.Starred) for a in node.args):
            raise self._error(node, f"{name} takes {expected} argument{'s' * (expected > 1)}")
        if name == "mean":
            variable = node.args[1]
            if not isinstance(variable, ast.Name):
                raise self._error(variable, "the variable of a mean is a name")
            _Check(self._names | {variable.id}, self._where, self._text).visit(node.args[0])
        else:
            self.visit(node.args[0])
        within = [one for one in map(function_of, ast.walk(node)) if one == name]
        if name in OPERATORS and len(within) > _MOST_WITHIN[name]:
            raise self._error(node, f"more than {_MOST_WITHIN[name]} times {name} within each other")
        self._check_number(node)

    def _check_number(self, node: ast.expr) -> None:
        """Refuse a part of numbers alone that has no value."""
        names = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
        if not names <= {*FUNCTIONS, "pi"}:
            return
        try:
            value = _value(node, {})
        except (ArithmeticError, ValueError):
            value = math.nan
        if not abs(value) < _LARGEST:
            raise self._error(node, "this is no number")

    def _error(self, node: ast.AST, problem: str) -> OptionError:
        return error_at(self._where, self._text, node, problem)


def _nearest(name: str, known: Collection[str]) -> str:
    near = difflib.get_close_matches(name, known, 1)
    return f"; did you mean {near[0]}?" if near else f"; known are {', '.join(sorted(known))}"


def names_used(texts: Iterable[str]) -> set[str]:
    """Return the names that formulas use, functions aside."""
    return set[str]().union(*(names_in(tree_of(text)) for text in texts))


def evaluated(text: str, values: Mapping[str, float]) -> float:
    """Return what a formula of given numbers is; it has passed `parse`, and has no mean or rate."""
    return _value(tree_of(text), values)


def _value(tree: Tree, values: Mapping[str, float]) -> float:
    known = {name: number(value) for name, value in {"pi": math.pi, **values}.items()}
    value = as_number(substituted(tree, known))
    assert value is not None
    return value
