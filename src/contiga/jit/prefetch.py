"""Prefetch of a row of an array before it is needed.

It affects only time. Rows that are read at random, with a branch that depends on each, are
otherwise read one by one.
"""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
from numba import config
from numba.core import cgutils
from numba.core import types as numba_types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

types: Any = numba_types
LINE = 64
"""Size of a cache line, bytes."""


def no_prefetch(array: Any, row: int, offset: int) -> None:
    """Do nothing: the interpreter cannot prefetch."""


@intrinsic  # type: ignore[untyped-decorator]
def _prefetch(typingctx: Any, array: Any, row: Any, offset: Any) -> Any:
    if not (isinstance(array, types.Array) and isinstance(offset, types.Integer)):
        return None

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        rows = make_array(signature.args[0])(context, builder, args[0])
        first = builder.extract_value(rows.strides, 0)
        byte = ir.IntType(8).as_pointer()
        off = builder.add(builder.mul(args[1], first), args[2])
        at = builder.gep(builder.bitcast(rows.data, byte), [off])
        integer = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [byte, integer, integer, integer])
        name = "llvm.prefetch.p0"
        function = cgutils.get_or_insert_function(builder.module, kind, name)
        # For reading, into all levels of the cache, data and not code.
        builder.call(function, [at, integer(0), integer(3), integer(1)])
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp), generate


prefetch = no_prefetch if config.DISABLE_JIT else _prefetch
"""prefetch(array, row, offset): request the cache line `offset` bytes into a row, which need not
exist."""
