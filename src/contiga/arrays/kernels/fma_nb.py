"""The explicit fused multiply-add: x·y + z rounded once (IEEE 754, 5.4.1).

The compiler may neither fuse nor split multiply-adds on its own, so that a kernel gives the same
bits on every processor. LLVM vectorises the intrinsic; a processor without the instruction calls
the library's function, which is slow and gives the same value.
"""

from __future__ import annotations

import math

from numba import config
from numba.core import types
from numba.extending import intrinsic


def exact_fma(x, y, z):
    """Return x·y + z of floats, rounded once, by exact integers instead of the instruction."""
    x, y, z = float(x), float(y), float(z)
    rounded = x * y + z
    if not math.isfinite(x) or not math.isfinite(y):
        return rounded
    if not math.isfinite(z):
        return z
    (a, b), (c, d), (e, f) = (v.as_integer_ratio() for v in (x, y, z))
    numerator = a * c * f + e * b * d
    if numerator == 0:
        return rounded  # with the sign that zeros have
    try:
        # The quotient of two integers is rounded once, also where it is subnormal.
        size = abs(numerator) / (b * d * f)
    except OverflowError:
        size = math.inf
    return size if numerator > 0 else -size


@intrinsic
def _fma_intrinsic(typingctx, x, y, z):
    if not all(isinstance(v, types.Float) for v in (x, y, z)):
        return None

    def generate(context, builder, signature, args):
        return builder.fma(*args)

    double = types.float64
    return double(double, double, double), generate


fma = exact_fma if config.DISABLE_JIT else _fma_intrinsic
