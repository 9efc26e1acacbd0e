"""Vector moves of blocks of numbers: a 4 × 4 transpose, and a read that is not hoisted.

They affect only time. Where the rows that are read are records and the rows that are written are
lanes, the compiler moves one number after another. And it reads a value that does not change within
a loop once, before the loop: of many such numbers each then stays on the stack, as a whole vector.
"""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba import config
from numba.core import types as numba_types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from contiga.jit.scratch import SIZE as SIZE

types: Any = numba_types
N_LANES = 4
"""Numbers of a vector."""
PAIRS = ((0, 4, 2, 6), (1, 5, 3, 7))
HALVES = ((0, 1, 4, 5), (2, 3, 6, 7))
"""Orders of the numbers of two vectors, one after the other."""


def transpose(source: Any, rows: Any, to: Any, columns: Any) -> None:
    """Transpose the block number by number, for the interpreter; see `turn`."""
    a, b = (x.reshape(-1).view(np.uint8).view(np.float64) for x in (source, to))
    block = [[a[row + c] for c in range(N_LANES)] for row in rows]
    for c in reversed(range(N_LANES)):
        for i in range(N_LANES):
            b[columns[c] + i] = block[i][c]


def copy_numbers(source: Any, to: Any, n: int) -> None:
    """Copy the first n numbers of `source` to `to`, for the interpreter; see `reload_numbers`."""
    to[:n] = source[:n]


@intrinsic  # type: ignore[untyped-decorator]
def _transpose(typingctx: Any, source: Any, rows: Any, to: Any, columns: Any) -> Any:
    if not (isinstance(source, types.Array) and isinstance(to, types.Array)):
        return None
    fours = types.UniTuple(types.int64, N_LANES)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.VectorType(ir.DoubleType(), N_LANES)

        def places(k: int) -> list[Any]:
            first = make_array(signature.args[k])(context, builder, args[k]).data
            number = builder.bitcast(first, ir.DoubleType().as_pointer())
            at = [builder.extract_value(args[k + 1], i) for i in range(N_LANES)]
            return [builder.bitcast(builder.gep(number, [i]), vector.as_pointer()) for i in at]

        def mixed(a: Any, b: Any, which: tuple[int, ...]) -> Any:
            return builder.shuffle_vector(
                a, b, ir.Constant(ir.VectorType(ir.IntType(32), N_LANES), which)
            )

        a, b, c, d = (builder.load(place, align=SIZE) for place in places(0))
        above, below = ([mixed(*two, which) for which in PAIRS] for two in ((a, b), (c, d)))
        transposed = [mixed(above[i], below[i], which) for which in HALVES for i in range(2)]
        for value, place in reversed(list(zip(transposed, places(2), strict=True))):
            builder.store(value, place, align=SIZE)
        return context.get_dummy_value()

    return types.void(source, fours, to, fours), generate


@intrinsic  # type: ignore[untyped-decorator]
def _copy_numbers(typingctx: Any, source: Any, to: Any, n: Any) -> Any:
    if not (isinstance(source, types.Array) and isinstance(to, types.Array)):
        return None

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        byte = ir.IntType(8).as_pointer()
        first, second = (
            builder.bitcast(make_array(array_type)(context, builder, value).data, byte)
            for array_type, value in zip(signature.args[:2], args[:2], strict=True)
        )
        # Assembly without instructions, which for the compiler may return another address.
        first = builder.asm(ir.FunctionType(byte, [byte]), "", "=r,0", [first], side_effect=True)
        kind = ir.FunctionType(ir.VoidType(), [byte, byte, ir.IntType(64), ir.IntType(1)])
        name = "llvm.memcpy.p0.p0.i64"
        function = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        length = builder.mul(args[2], ir.Constant(ir.IntType(64), SIZE))
        builder.call(function, [second, first, length, ir.Constant(ir.IntType(1), 0)])
        return context.get_dummy_value()

    return types.void(source, to, types.int64), generate


def to_bits(x: float) -> int:
    """Return the bits of a number as an integer."""
    return int(np.float64(x).view(np.int64))


@intrinsic  # type: ignore[untyped-decorator]
def _to_bits(typingctx: Any, x: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), generate


turn = transpose if config.DISABLE_JIT else _transpose
"""turn(source, rows, to, columns): transpose four numbers from each of four places of an array.

The first numbers of all rows go to the first of four places in the array `to`, and so on. Places
are counted in numbers. They are written from the last to the first: where they overlap the first
wins.
"""
reload_numbers = copy_numbers if config.DISABLE_JIT else _copy_numbers
"""reload_numbers(source, to, n): copy the first n numbers of an array, always at this place in the
code."""
bits_of = to_bits if config.DISABLE_JIT else _to_bits
"""bits_of(x): the 64 bits of a number as an integer."""
