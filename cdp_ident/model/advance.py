# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The derivatives of a state, carried through a step of the integrator: machine code that computes directions together.

They follow the state's own Runge-Kutta step, whose stages left their derivatives by the state and by the directions.
"""

import inspect
import sys
from functools import cache
from typing import Any

from llvmlite import ir

from cdp_ident.model import layout as at
from cdp_ident.model.formulas.machine_code import Addresses

_NUMBER, _INDEX = ir.DoubleType(), ir.IntType(64)
_NUMBERS = _NUMBER.as_pointer()
_LANES = ir.VectorType(_NUMBER, at.VECTOR)
_FAST = ("fast",)


@cache
def address_of_advance(states: int) -> int:
    """Return the address of a function `advance(matrices, slopes, h, directions)` for so many states; see `layout`.

    It fills in the derivatives at the end of a step of length h [s], and their slopes there.
    """
    return _kept(states).of("advance")


@cache
def _kept(states: int) -> Addresses:
    stands_for = inspect.getsource(sys.modules[__name__])
    return Addresses(f"{states} {at.VECTOR} {at.ROOM} {at.ROWS_OF_SLOPES} {stands_for}", lambda: _module(states))


def _module(states: int) -> ir.Module:
    module = ir.Module("advance")
    kind = ir.FunctionType(ir.VoidType(), [_NUMBERS, _NUMBERS, _NUMBER, _INDEX])
    function = ir.Function(module, kind, "advance")
    matrices, slopes, h, directions = function.args
    matrices.add_attribute("noalias")
    slopes.add_attribute("noalias")
    begin, loop, end = (function.append_basic_block(name) for name in ("begin", "loop", "end"))
    build = ir.IRBuilder(begin)
    build.cbranch(build.icmp_signed(">", directions, _INDEX(0)), loop, end)
    build.position_at_end(loop)
    first = build.phi(_INDEX)
    first.add_incoming(_INDEX(0), begin)
    _carry(_Lanes(build, matrices, slopes, first, states), h)
    following = build.add(first, _INDEX(at.VECTOR))
    first.add_incoming(following, loop)
    build.cbranch(build.icmp_signed("<", following, directions), loop, end)
    build.position_at_end(end)
    build.ret_void()
    return module


class _Lanes:
    """Some directions, one in each lane."""

    def __init__(self, build: ir.IRBuilder, matrices: Any, slopes: Any, first: Any, states: int) -> None:
        self.build, self._matrices, self._slopes, self._first, self.states = build, matrices, slopes, first, states

    def _place(self, number: int, row: int) -> Any:
        place = self.build.add(self._first, _INDEX((number * at.ROWS_OF_SLOPES + row) * at.ROOM))
        return self.build.bitcast(self.build.gep(self._slopes, [place]), _LANES.as_pointer())

    def row(self, row: int) -> list[Any]:
        """Return a row of all numbers of the state."""
        return [self.build.load(self._place(k, row), align=8) for k in range(self.states)]

    def put(self, row: int, values: list[Any]) -> None:
        """Store a row of all numbers of the state."""
        for k, value in enumerate(values):
            self.build.store(value, self._place(k, row), align=8)

    def everywhere(self, number: Any) -> Any:
        """Return a number in every lane."""
        one = self.build.insert_element(ir.Constant(_LANES, ir.Undefined), number, ir.IntType(32)(0))
        every = ir.Constant(ir.VectorType(ir.IntType(32), at.VECTOR), [0] * at.VECTOR)
        return self.build.shuffle_vector(one, ir.Constant(_LANES, ir.Undefined), every)

    def plus(self, value: Any, factor: Any, other: Any) -> Any:
        """Return a value and so many times another together."""
        return self.build.fadd(value, self.build.fmul(factor, other, flags=_FAST), flags=_FAST)

    def slopes(self, stage: int, derivatives: list[Any]) -> list[Any]:
        """Return the slopes of derivatives at a stage: of angles they are those of the speeds."""
        found = derivatives[2:4]
        for number in range(2, self.states):
            total = self.build.load(self._place(number, at.DIRECT + stage), align=8)
            for k, value in enumerate(derivatives):
                place = _INDEX((stage * self.states + number) * self.states + k)
                element = self.build.load(self.build.gep(self._matrices, [place]))
                total = self.plus(total, self.everywhere(element), value)
            found.append(total)
        return found


def _carry(lanes: _Lanes, h: Any) -> None:
    def share(divisor: float) -> Any:
        return lanes.everywhere(lanes.build.fmul(h, _NUMBER(1.0 / divisor), flags=_FAST))

    def moved(of: list[Any], factor: Any, by: list[Any]) -> list[Any]:
        return [lanes.plus(value, factor, other) for value, other in zip(of, by, strict=True)]

    whole, half, third, sixth = (share(divisor) for divisor in (1.0, 2.0, 3.0, 6.0))
    old, slopes = lanes.row(at.OLD), lanes.row(at.OLD_SLOPE)
    new, there = moved(old, sixth, slopes), moved(old, half, slopes)
    for stage in (1, 2, 3):
        slopes = lanes.slopes(stage, there)
        new = moved(new, sixth if stage == 3 else third, slopes)
        there = moved(old, half if stage == 1 else whole, slopes)
    lanes.put(at.NEW, new)
    lanes.put(at.NEW_SLOPE, lanes.slopes(4, new))
