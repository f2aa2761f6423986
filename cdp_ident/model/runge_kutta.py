# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One step of the integrator, and the derivatives of the state carried along (compiled).

The derivatives, by the state at the beginning, by coefficients and by parameters, go through the same steps as the
state (the tangent linear model of the integrator), whose stages left their derivatives by the state and by the
directions. Machine code made by LLVM directly computes several directions with one instruction.
"""

from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils

from cdp_ident.machine.compilation import Addresses, call, inlined, part, place
from cdp_ident.model import layout as at
from cdp_ident.model.layout import unfolded
from cdp_ident.model.rates import STICKS

_ROUGH = 3e-6
"""Largest error estimate of a step: see `roughness`."""
_NUMBER, _INDEX = ir.DoubleType(), ir.IntType(64)
_NUMBERS = _NUMBER.as_pointer()
_LANES = ir.VectorType(_NUMBER, at.VECTOR)
_FAST = ("fast",)


@inlined
def input_at(work, share):
    """Return the cart's acceleration at a share of the step, from those at its beginning, middle and end."""
    u = work.numbers
    first, middle, last = u[at.CART_INPUTS], u[at.CART_INPUTS + 1], u[at.CART_INPUTS + 2]
    return first * (1.0 - share) * (1.0 - 2.0 * share) + share * (
        4.0 * middle * (1.0 - share) + last * (2.0 * share - 1.0)
    )


@part
def stop(state, joint):
    """Set a joint's speed to exactly zero."""
    if joint == 0:
        state[2] = 0.0
    else:
        state[3] = state[2]


def step_on(plan, motion, room, begin, step, done, share, end, derive):
    """Make one Runge-Kutta step of a share of the grid's, from the share `done` on.

    The grid's step begins at a time in the trial [s] and has a length [s]. The rates at the beginning are in row 0
    already; the last row is at the end, the state at which goes to the row `end` of the states. Where asked to
    `derive`, rates have their jacobians.
    """
    _, work = unfolded(plan, room)
    states = work.states
    h, n = share * step, states.shape[1]
    for stage in range(1, at.STAGES):
        there = done + (0.5 * share if stage < 3 else share)
        row = at.HERE
        if stage < 4:
            offset = h if stage == 3 else 0.5 * h
            for r in range(n):
                states[at.HERE, r] = states[at.BEGIN, r] + offset * states[at.RATES_AT + stage - 1, r]
        else:
            # The rates at the end are the next step's first, and give the measurements in this one their slopes.
            row = end
            for r in range(n):
                states[end, r] = states[at.BEGIN, r] + h / 6.0 * (
                    states[at.RATES_AT, r]
                    + states[at.RATES_AT + 3, r]
                    + 2.0 * (states[at.RATES_AT + 1, r] + states[at.RATES_AT + 2, r])
                )
            for joint in range(2):
                if work.modes[at.MODE, joint] == STICKS:
                    stop(states[end], joint)
        t, u = begin + there * step, input_at(work, there)
        call(plan[at.FILL_RATES], (plan, motion, room, row, t, u, stage, derive))


@inlined
def roughness(work, h):
    """Return the error of a step over the largest allowed: the rates at its last stage and its end differ by it."""
    largest = 0.0
    for r in range(work.states.shape[1]):
        largest = max(largest, abs(work.states[at.RATES_AT + 4, r] - work.states[at.RATES_AT + 3, r]))
    return h * largest / (6.0 * _ROUGH)


@inlined
def hermite(s, h):
    """Return the weights of both ends' values, and of both ends' slopes, at a share of a step of a length [s]."""
    square = (1.0 - s) * (1.0 - s)
    return (1.0 + 2.0 * s) * square, s * s * (3.0 - 2.0 * s), h * s * square, h * s * s * (s - 1.0)


@part
def fill_first_slopes(work):
    """Fill in the slopes of the derivatives at a step's beginning."""
    for d in range(work.directions):
        work.slopes[0, at.OLD_SLOPE, d], work.slopes[1, at.OLD_SLOPE, d] = (
            work.slopes[2, at.OLD, d],
            work.slopes[3, at.OLD, d],
        )
    for r in range(2, work.states.shape[1]):
        chain(work, r, at.RATES_BY, at.OLD, place(work.slopes, (r * at.ROWS_OF_SLOPES + at.OLD_SLOPE) * at.ROOM), False)


@part
def chain(work, number, by_row, row, target, added):
    """Fill in the derivatives by all directions of a number, or add them, given its own and a row of the state's."""
    slopes, n = work.slopes, work.states.shape[1]
    for d in range(np.uint64(work.directions)):
        target[d] = (target[d] if added else 0.0) + slopes[number, by_row, n + d]
    for k in range(n):
        slope = slopes[number, by_row, k]
        for d in range(np.uint64(work.directions if slope != 0.0 else 0)):
            target[d] += slope * slopes[k, row, d]


@part
def accept(work):
    """Let a step's end be the next one's beginning."""
    for r in range(work.states.shape[1]):
        work.states[at.BEGIN, r], work.states[at.RATES_AT, r] = work.states[at.END, r], work.states[at.RATES_AT + 4, r]
        for d in range(np.uint64(work.directions)):
            work.slopes[r, at.OLD, d] = work.slopes[r, at.NEW, d]
            work.slopes[r, at.OLD_SLOPE, d] = work.slopes[r, at.NEW_SLOPE, d]


@cache
def address_of_advance(states: int) -> int:
    """Return the address of a function `advance(slopes, h, directions)` for so many states; see `layout`.

    It fills in the derivatives at the end of a step of length h [s], and their slopes there.
    """
    return Addresses(f"advance {states}", lambda: _module(states)).of("advance")


def _module(states: int) -> ir.Module:
    module = ir.Module("advance")
    kind = ir.FunctionType(ir.VoidType(), [_NUMBERS, _NUMBER, _INDEX])
    function = ir.Function(module, kind, "advance")
    slopes, h, directions = function.args
    build = ir.IRBuilder(function.append_basic_block())
    with cgutils.for_range_slice(build, _INDEX(0), directions, _INDEX(at.VECTOR)) as (first, _):
        _carry(_Lanes(build, slopes, first, states), h)
    build.ret_void()
    return module


class _Lanes:
    """Some directions, one in each lane."""

    def __init__(self, build: ir.IRBuilder, slopes: Any, first: Any, states: int) -> None:
        self.build, self._slopes, self._first, self.states = build, slopes, first, states

    def _place(self, number: int, row: int, further: int = 0) -> Any:
        place = self.build.add(self._first, _INDEX((number * at.ROWS_OF_SLOPES + row) * at.ROOM + further))
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
            row = at.RATES_BY + stage
            total = self.build.load(self._place(number, row, self.states), align=8)
            for k, value in enumerate(derivatives):
                place = _INDEX((number * at.ROWS_OF_SLOPES + row) * at.ROOM + k)
                element = self.build.load(self.build.gep(self._slopes, [place]))
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
