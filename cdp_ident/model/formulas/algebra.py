# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Arithmetic with formulas: Python's own syntax trees, put together with what is 0, 1 or a number worked out."""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

Tree: TypeAlias = ast.expr

OPERATIONS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: math.pow,
}  # fmt: skip
_CHANGES_NOTHING = {ast.Add: 0.0, ast.Sub: 0.0, ast.Mult: 1.0, ast.Div: 1.0, ast.Pow: 1.0}
"""Which number does nothing on the right of an operation."""
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "atan": math.atan, "tanh": math.tanh, "exp": math.exp,
    "log": math.log, "sqrt": math.sqrt, "abs": abs, "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
    "step": lambda x: float(x >= 0.0),
}  # fmt: skip
"""`step(x)` is 1 from zero on, and 0 before."""


def number(value: float) -> Tree:
    """Return a number as a tree."""
    size = abs(float(value))
    constant = ast.Constant(int(size) if size.is_integer() and size < 1e15 else size)
    return ast.UnaryOp(ast.USub(), constant) if value < 0.0 else constant


def as_number(tree: Tree) -> float | None:
    """Return the number that a tree is; None where it has names."""
    if is_negative(tree):
        size = as_number(tree.operand)  # type: ignore[attr-defined]
        return None if size is None else -size
    return float(tree.value) if isinstance(tree, ast.Constant) else None  # type: ignore[arg-type]


def is_negative(tree: Tree) -> bool:
    """Return whether a tree is minus another one."""
    return isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub)


def negative(tree: Tree) -> Tree:
    """Return minus a tree."""
    return tree.operand if is_negative(tree) else ast.UnaryOp(ast.USub(), tree)  # type: ignore[attr-defined]


def combined(operation: type[ast.operator], left: Tree, right: Tree) -> Tree:
    """Return what an operation makes of two trees. Raises `ArithmeticError` or `ValueError` where that is no number."""
    a, b, is_product = as_number(left), as_number(right), operation in (ast.Mult, ast.Div)
    if a is not None and b is not None:
        return number(OPERATIONS[operation](a, b))
    if operation is ast.Div and b == 0.0:
        raise ZeroDivisionError
    if b == _CHANGES_NOTHING[operation]:
        return left
    if operation in (ast.Add, ast.Mult) and a == _CHANGES_NOTHING[operation]:
        return right
    if is_product and 0.0 in (a, b):
        return number(0.0)
    if operation is ast.Sub and isinstance(left, ast.Name) and isinstance(right, ast.Name) and left.id == right.id:
        return number(0.0)
    if operation is ast.Sub and a == 0.0:
        return negative(right)
    if is_product and is_negative(left):
        return negative(combined(operation, negative(left), right))
    if is_product and is_negative(right):
        return negative(combined(operation, left, negative(right)))
    if operation in (ast.Add, ast.Sub) and is_negative(right):
        return combined(ast.Sub if operation is ast.Add else ast.Add, left, negative(right))
    return ast.BinOp(left, operation(), right)


def applied(name: str, argument: Tree) -> Tree:
    """Return what a function makes of a tree."""
    value = as_number(argument)
    return ast.Call(ast.Name(name), [argument], []) if value is None else number(FUNCTIONS[name](value))


def rebuilt(tree: Tree, named: Callable[[str], Tree], called: Callable[[str, Sequence[Tree]], Tree]) -> Tree:
    """Return a tree with its names, and what it calls with which arguments, replaced."""
    if isinstance(tree, ast.Name):
        return named(tree.id)
    if isinstance(tree, ast.Call):
        return called(function_of(tree), tree.args)
    if isinstance(tree, ast.UnaryOp):
        operand = rebuilt(tree.operand, named, called)
        return negative(operand) if isinstance(tree.op, ast.USub) else operand
    if isinstance(tree, ast.BinOp):
        left, right = rebuilt(tree.left, named, called), rebuilt(tree.right, named, called)
        return combined(type(tree.op), left, right)
    assert isinstance(tree, ast.Constant)
    return number(tree.value)  # type: ignore[arg-type]


def substituted(tree: Tree, known: Mapping[str, Tree], function: Callable[[str, Tree], Tree] = applied) -> Tree:
    """Return a tree with trees in the place of some names, and functions as `function` writes them."""

    def called(name: str, arguments: Sequence[Tree]) -> Tree:
        return function(name, rebuilt(arguments[0], named, called))

    def named(name: str) -> Tree:
        return known.get(name) or ast.Name(name)

    return rebuilt(tree, named, called)


def function_of(tree: ast.AST) -> str:
    """Return the name of the function that a tree calls, if it calls one."""
    return tree.func.id if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) else ""


def names_in(tree: Tree) -> set[str]:
    """Return the names in a tree, functions aside."""
    nodes = list(ast.walk(tree))
    functions = {id(node.func) for node in nodes if isinstance(node, ast.Call)}
    return {node.id for node in nodes if isinstance(node, ast.Name) and id(node) not in functions}
