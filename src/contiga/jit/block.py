"""Blocks of numbers moved as vectors: four rows turned into four columns, and a fresh read.

They change nothing but time. The compiler takes one number after another where what it reads lies
in rows of records and what it writes in rows of lanes. And what does not change within a loop it
reads once, before that: of many numbers each is then kept on the stack, as a whole vector.
"""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba import config
from numba.core import types as numba_types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

types: Any = numba_types
SIZE = 8
"""Size of a number, bytes."""
FOUR = 4
PAIRS = ((0, 4, 2, 6), (1, 5, 3, 7))
HALVES = ((0, 1, 4, 5), (2, 3, 6, 7))
"""Order of the numbers of two vectors, one after the other."""


def turned(source: Any, rows: Any, to: Any, columns: Any) -> None:
    """Transpose number by number."""
    a, b = (x.reshape(-1).view(np.uint8).view(np.float64) for x in (source, to))
    block = [[a[row + c] for c in range(FOUR)] for row in rows]
    for c in reversed(range(FOUR)):
        for i in range(FOUR):
            b[columns[c] + i] = block[i][c]


def copied(source: Any, to: Any, n: int) -> None:
    """Copy number by number."""
    to[:n] = source[:n]


@intrinsic  # type: ignore[untyped-decorator]
def _turned(typingctx: Any, source: Any, rows: Any, to: Any, columns: Any) -> Any:
    if not (isinstance(source, types.Array) and isinstance(to, types.Array)):
        return None
    fours = types.UniTuple(types.int64, FOUR)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.VectorType(ir.DoubleType(), FOUR)

        def places(k: int) -> list[Any]:
            first = make_array(signature.args[k])(context, builder, args[k]).data
            number = builder.bitcast(first, ir.DoubleType().as_pointer())
            at = [builder.extract_value(args[k + 1], i) for i in range(FOUR)]
            return [builder.bitcast(builder.gep(number, [i]), vector.as_pointer()) for i in at]

        def mixed(a: Any, b: Any, which: tuple[int, ...]) -> Any:
            return builder.shuffle_vector(
                a, b, ir.Constant(ir.VectorType(ir.IntType(32), FOUR), which)
            )

        a, b, c, d = (builder.load(place, align=SIZE) for place in places(0))
        above, below = ([mixed(*two, which) for which in PAIRS] for two in ((a, b), (c, d)))
        turned = [mixed(above[i], below[i], which) for which in HALVES for i in range(2)]
        for value, place in reversed(list(zip(turned, places(2), strict=True))):
            builder.store(value, place, align=SIZE)
        return context.get_dummy_value()

    return types.void(source, fours, to, fours), generate


@intrinsic  # type: ignore[untyped-decorator]
def _copied(typingctx: Any, source: Any, to: Any, n: Any) -> Any:
    if not (isinstance(source, types.Array) and isinstance(to, types.Array)):
        return None

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        byte = ir.IntType(8).as_pointer()
        first, second = (
            builder.bitcast(make_array(of)(context, builder, value).data, byte)
            for of, value in zip(signature.args[:2], args[:2], strict=True)
        )
        # Text of no instructions that may give another place.
        first = builder.asm(ir.FunctionType(byte, [byte]), "", "=r,0", [first], side_effect=True)
        kind = ir.FunctionType(ir.VoidType(), [byte, byte, ir.IntType(64), ir.IntType(1)])
        name = "llvm.memcpy.p0.p0.i64"
        function = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        length = builder.mul(args[2], ir.Constant(ir.IntType(64), SIZE))
        builder.call(function, [second, first, length, ir.Constant(ir.IntType(1), 0)])
        return context.get_dummy_value()

    return types.void(source, to, types.int64), generate


def whole(x: float) -> int:
    """Return the same bits as a whole number."""
    return int(np.float64(x).view(np.int64))


@intrinsic  # type: ignore[untyped-decorator]
def _whole(typingctx: Any, x: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), generate


turn = turned if config.DISABLE_JIT else _turned
"""turn(source, rows, to, columns): the four numbers from each of four places in the memory of one
array as columns, that is the first ones from the first of four places in another, and so on.

Places are counted in numbers. Those of `to` are written from the last to the first: where they lie
one in another the first holds.
"""
read_anew = copied if config.DISABLE_JIT else _copied
"""read_anew(source, to, n): the first n numbers of an array into another; always at this place."""
bits_of = whole if config.DISABLE_JIT else _whole
"""bits_of(x): the 64 bits of a number as a whole one."""
