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
from cdp_ident.model.formulas.algebra import as_number, function_of
from cdp_ident.model.formulas.code import name_of, paper_text, text_of

_NUMBER, _PLACE = ir.DoubleType(), ir.IntType(64)
_NUMBERS = _NUMBER.as_pointer()
_FAST = ("fast",)
_INTRINSICS = {name: f"llvm.{name}" for name in ("sin", "cos", "exp", "log", "sqrt")} | {"abs": "llvm.fabs"}
_OF_C = {name: name for name in ("tan", "atan", "tanh")}
_POWERS = (1.0, 2.0, 3.0, 4.0)
"""Whole powers that are products."""

_paper: dict[str, Any] = {"__name__": __name__}
exec(compile(paper_text(), "<the equations of motion>", "exec"), _paper)
pushes, slopes_of_paper = (inlined(_paper[name]) for name in ("pushes", "slopes_of_paper"))
"""The paper's equations, and their derivatives; see `code`."""


def compiled_law(effect: Effect, is_zero: bool = False) -> int:
    """Return the address of an effect's law, compiled.

    Of no strength it does nothing, and there are only derivatives by its strengths, where its states are known then.
    """
    return _address(effect, is_zero and effect.known_at_zero and effect.curve is None)


@cache
def _address(effect: Effect, at_zero: bool) -> int:
    if effect.curve is not None:
        return compiled_at(effect.curve.law, OF_LAW) if effect.curve.law else 0
    return _machine_code(WRITTEN if effect in WRITTEN else (effect,)).of(name_of(effect, at_zero))


@cache
def _machine_code(effects: tuple[Effect, ...]) -> Addresses:
    """Return the laws of effects as machine code; it is that of their formulas, and of our sources."""
    made_of = [(name_of(one), one.law, one.joint, [p.name for p in one.parameters]) for one in effects]
    return Addresses(repr(made_of), lambda: _module_of(text_of(effects)))


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
        if isinstance(node, ast.BinOp):
            return self._combined(node)
        assert isinstance(node, ast.Call)
        name, argument = function_of(node), self._value(node.args[0])
        if name == "step":
            return self._where(">=", argument)
        if name == "sign":
            return build.fsub(self._where(">", argument), self._where("<", argument), flags=_FAST)
        return self._call((_INTRINSICS | _OF_C)[name], argument)

    def _combined(self, node: ast.BinOp) -> Any:
        build, left, power = self._builder, self._value(node.left), as_number(node.right)
        if not isinstance(node.op, ast.Pow):
            operations: dict[type[ast.operator], Callable[..., Any]] = {
                ast.Add: build.fadd, ast.Sub: build.fsub, ast.Mult: build.fmul, ast.Div: build.fdiv,
            }  # fmt: skip
            return operations[type(node.op)](left, self._value(node.right), flags=_FAST)
        if power is None or abs(power) not in _POWERS:
            return self._call("llvm.pow", left, self._value(node.right))
        product = left
        for _ in range(int(abs(power)) - 1):
            product = build.fmul(product, left, flags=_FAST)
        return product if power > 0.0 else build.fdiv(_NUMBER(1.0), product, flags=_FAST)

    def _where(self, sign: str, value: Any) -> Any:
        """Return 1 where a number is on a side of zero, and else 0."""
        return self._builder.select(self._builder.fcmp_ordered(sign, value, _NUMBER(0.0)), _NUMBER(1.0), _NUMBER(0.0))

    def _call(self, name: str, *values: Any) -> Any:
        if name in _OF_C:
            kind = ir.FunctionType(_NUMBER, [_NUMBER])
            function = self._module.globals.get(name) or ir.Function(self._module, kind, name)
        else:
            function = self._module.declare_intrinsic(name, [_NUMBER])
        return self._builder.call(function, values, fastmath=_FAST)
