"""A number in memory that another thread may write: read anew each time it is asked for.

A compiler that sees nothing in a loop write it would read it once, before.
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
SIZE = 8
"""Bytes of the number."""


def first(numbers: Any) -> Any:
    """The same in the interpreter."""
    return numbers[0]


@intrinsic  # type: ignore[untyped-decorator]
def _glance(typingctx: Any, numbers: Any) -> Any:
    if not (isinstance(numbers, types.Array) and numbers.dtype == types.int64):
        return None

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = make_array(signature.args[0])(context, builder, args[0]).data
        if context.codegen().magic_tuple()[0].startswith("x86_64"):
            # A loop that waits leaves the core to others on it, and ends without guessed reads.
            kind = ir.FunctionType(ir.VoidType(), [])
            pause = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.sse2.pause")
            builder.call(pause, [])
        return builder.load_atomic(place, "acquire", SIZE)

    return types.int64(numbers), generate


glance = first if config.DISABLE_JIT else _glance
"""glance(numbers): numbers[0], int64, as it stands in memory; takes some 25 ns, most of it rest."""
