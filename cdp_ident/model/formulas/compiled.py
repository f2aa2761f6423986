# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The equations of motion and laws as compiled code.

Laws' code is made into machine code by LLVM directly. It is arithmetic, one line after the other, so that nothing has
to be found out about it; the compiler of the loops, which must, would take a second for each law.
"""

import ast
import math
from collections.abc import Callable
from functools import cache
from typing import Any

from llvmlite import ir

from cdp_ident.machine.compilation import OF_LAW, Addresses, compiled_at, inlined
from cdp_ident.model.effects.catalogue import WRITTEN
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.formulas.generated import Generated, module_of

_NUMBER, _PLACE = ir.DoubleType(), ir.IntType(64)
_NUMBERS = _NUMBER.as_pointer()
_FAST = ("fast",)
_INTRINSICS = {name: f"llvm.{name}" for name in ("sin", "cos", "exp", "log", "sqrt")} | {"abs": "llvm.fabs"}
_OF_C = ("tan", "atan", "tanh")
_COMPARISONS: dict[type[ast.cmpop], str] = {ast.Gt: ">", ast.Lt: "<", ast.GtE: ">="}

_CATALOGUE = module_of(WRITTEN, paper=True)
pushes, slopes_of_paper = inlined(_CATALOGUE.pushes), inlined(_CATALOGUE.slopes_of_paper)
"""The paper's equations, and their derivatives; see `code`."""


def motion_law(effect: Effect, is_zero: bool = False) -> int:
    """Return the address of what an effect's law does to the motion, compiled; 0 where it does nothing.

    Of no strength it does nothing either, and there are only derivatives by its strengths.
    """
    return _address(effect, "MOTION_AT_ZERO" if is_zero and effect.known_at_zero and not effect.curve else "MOTION")


def reading_law(effect: Effect, is_zero: bool = False) -> int:
    """Return the address of what it does to readings, likewise."""
    return _address(effect, "READING_AT_ZERO" if is_zero and effect.known_at_zero else "READING")


@cache
def _address(effect: Effect, table: str) -> int:
    if effect.curve is not None:
        return compiled_at(effect.curve.law, OF_LAW) if effect.curve.law and table == "MOTION" else 0
    module = _CATALOGUE if effect.key in _CATALOGUE.KEYS else module_of((effect,), paper=False)
    function = getattr(module, table).get(effect.key)
    return 0 if function is None else _machine_code(module).of(function.__name__)


@cache
def _machine_code(module: Generated) -> Addresses:
    return laws_in(module.text)


def laws_in(text: str) -> Addresses:
    """Return the functions in the text of laws' code as machine code."""
    return Addresses(text, lambda: _module_of(text))


def _module_of(text: str) -> ir.Module:
    module = ir.Module("laws")
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef) and node.args.args[0].arg == "z":
            _Function(module, node)
    return module


class _Function:
    """One function of laws' code, line by line."""

    def __init__(self, module: ir.Module, node: ast.FunctionDef) -> None:
        self._module = module
        arguments = node.args.args
        function = ir.Function(module, ir.FunctionType(ir.VoidType(), [_NUMBERS] * len(arguments)), node.name)
        for argument in function.args:
            argument.add_attribute("noalias")
        self._builder = ir.IRBuilder(function.append_basic_block())
        self._named: dict[str, Any] = {a.arg: value for a, value in zip(arguments, function.args, strict=True)}
        self._named["pi"] = ir.Constant(_NUMBER, math.pi)
        for line in node.body:
            if isinstance(line, ast.Assign):
                self._assign(line.targets[0], self._value(line.value))
            elif isinstance(line, ast.AugAssign):
                before = self._builder.load(self._element(line.target))
                self._assign(line.target, self._builder.fadd(before, self._value(line.value), flags=_FAST))
        self._builder.ret_void()

    def _assign(self, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Name):
            self._named[target.id] = value
        else:
            self._builder.store(value, self._element(target))

    def _element(self, node: ast.expr) -> Any:
        assert isinstance(node, ast.Subscript)
        assert isinstance(node.value, ast.Name)
        assert isinstance(node.slice, ast.Constant)
        return self._builder.gep(self._named[node.value.id], [ir.Constant(_PLACE, node.slice.value)])

    def _value(self, node: ast.expr) -> Any:
        build = self._builder
        if isinstance(node, ast.Constant):
            return ir.Constant(_NUMBER, float(node.value))  # type: ignore[arg-type]
        if isinstance(node, ast.Name):
            return self._named[node.id]
        if isinstance(node, ast.Subscript):
            return build.load(self._element(node))
        if isinstance(node, ast.UnaryOp):
            return build.fneg(self._value(node.operand), flags=_FAST)
        if isinstance(node, ast.IfExp):
            return build.select(self._condition(node.test), self._value(node.body), self._value(node.orelse))
        if isinstance(node, ast.BinOp):
            operations: dict[type[ast.operator], Callable[..., Any]] = {
                ast.Add: build.fadd, ast.Sub: build.fsub, ast.Mult: build.fmul, ast.Div: build.fdiv,
            }  # fmt: skip
            left, right = self._value(node.left), self._value(node.right)
            if isinstance(node.op, ast.Pow):
                return self._call("llvm.pow", left, right)
            return operations[type(node.op)](left, right, flags=_FAST)
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        return self._call(_INTRINSICS.get(node.func.id, node.func.id), self._value(node.args[0]))

    def _condition(self, node: ast.expr) -> Any:
        assert isinstance(node, ast.Compare)
        sign = _COMPARISONS[type(node.ops[0])]
        return self._builder.fcmp_ordered(sign, self._value(node.left), self._value(node.comparators[0]))

    def _call(self, name: str, *values: Any) -> Any:
        if name in _OF_C:
            kind = ir.FunctionType(_NUMBER, [_NUMBER])
            function = self._module.globals.get(name) or ir.Function(self._module, kind, name)
        else:
            function = self._module.declare_intrinsic(name, [_NUMBER])
        return self._builder.call(function, values, fastmath=_FAST)
