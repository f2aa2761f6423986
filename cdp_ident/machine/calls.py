# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Calls of compiled code by its address, and views of memory.

What is called so is compiled by itself: laws, of which loops know nothing when they are compiled, and the larger parts
of loops, which the compiler would otherwise go through again and again with everything that calls them.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

NUMBERS = types.CPointer(types.float64)
INDICES = types.CPointer(types.int64)
OF_LAW = types.void(NUMBERS, NUMBERS, NUMBERS, NUMBERS)
"""Signature of a compiled law: its inputs, its parameters, the sums of all laws, its rows."""


@intrinsic
def place(typing_context, array, index):
    """Return where in memory an element of a contiguous array is, counted along all its dimensions."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.bitcast(builder.gep(data, [arguments[1]]), context.get_value_type(signature.return_type))

    return types.CPointer(array.dtype)(array, index), generate


@intrinsic
def further(typing_context, pointer, index):
    """Return the place so many elements behind another one."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.gep(arguments[0], [arguments[1]])

    return pointer(pointer, index), generate


def _called(returned: types.Type) -> Callable[..., Any]:
    @intrinsic
    def call(typing_context, address, arguments):
        """Call what is at an address with some arguments, given in a tuple: places, whole numbers and numbers."""

        def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            values = cgutils.unpack_tuple(builder, given[1])
            result = ir.VoidType() if returned is types.void else context.get_value_type(returned)
            called = ir.FunctionType(result, [value.type for value in values]).as_pointer()
            value = builder.call(builder.inttoptr(given[0], called), values)
            return context.get_dummy_value() if returned is types.void else value

        return returned(address, arguments), generate

    return call


call, call_for_number = _called(types.void), _called(types.float64)
