"""Small work arrays of kernels on the stack, without allocation and reference counts."""

from __future__ import annotations

from math import prod
from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import make_array, populate_array

from contiga.records import FloatArray, IndexArray

types: Any = numba_types
SIZE = 8
"""Size of a number, bytes."""


def scratch(*shape: int) -> FloatArray:
    """Return an uninitialised array that ends with the kernel's call.

    A kernel must not return it. The shape consists of literal numbers or constants.
    """
    return np.empty(shape)


def zero_scratch(*shape: int) -> FloatArray:
    """Return an array of zeros that ends with the kernel's call."""
    return np.zeros(shape)


def stack_int64(*shape: int) -> IndexArray:
    """Return an uninitialised array of int64 that ends with the kernel's call."""
    return np.empty(shape, np.int64)


SCRATCH = (scratch, zero_scratch, stack_int64)


@infer_global(zero_scratch)
@infer_global(scratch)
class Scratch(AbstractTemplate):  # type: ignore[misc]
    """Typing template of a call of `scratch`."""

    prefer_literal = True
    number = types.float64

    def generic(self, shape: tuple[Any, ...], names: dict[str, Any]) -> Any:
        """Return the array type; None if the shape is not constant."""
        if names or not all(isinstance(count, types.IntegerLiteral) for count in shape):
            return None
        return signature(types.Array(self.number, len(shape), "C"), *shape)


@infer_global(stack_int64)
class IntegerScratch(Scratch):
    """Typing template of a call of `stack_int64`."""

    number = types.int64


@lower_builtin(stack_int64, types.VarArg(types.Any))  # type: ignore[untyped-decorator]
@lower_builtin(scratch, types.VarArg(types.Any))  # type: ignore[untyped-decorator]
def _on_the_stack(context: Any, builder: Any, call: Any, _: Any) -> Any:
    """Emit the code in the calling kernel: a separate function would release the memory."""
    return _stack_array(context, builder, call)[0]


@lower_builtin(zero_scratch, types.VarArg(types.Any))  # type: ignore[untyped-decorator]
def _zeros_on_the_stack(context: Any, builder: Any, call: Any, _: Any) -> Any:
    """Emit the code, and code that sets the array to zero."""
    value, place = _stack_array(context, builder, call)
    builder.store(ir.Constant(place.type.pointee, None), place)
    return value


def _stack_array(context: Any, builder: Any, call: Any) -> tuple[Any, Any]:
    """Emit code for an array of the type of a call on the stack; return it and its items' address.

    It is uninitialised, and does not count references.
    """
    counts = [count.literal_value for count in call.args]
    number = context.get_data_type(call.return_type.dtype)
    place = cgutils.alloca_once(builder, ir.ArrayType(number, prod(counts)))
    steps = [SIZE * prod(counts[k + 1 :]) for k in range(len(counts))]
    array = make_array(call.return_type)(context, builder)
    populate_array(
        array,
        data=builder.bitcast(place, number.as_pointer()),
        shape=[context.get_constant(types.intp, count) for count in counts],
        strides=[context.get_constant(types.intp, step) for step in steps],
        itemsize=context.get_constant(types.intp, SIZE),
        meminfo=None,
    )
    return array._getvalue(), place
