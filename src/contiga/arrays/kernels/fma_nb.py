"""The fused multiply-add, written where it is meant: x·y + z rounded once (IEEE 754, 5.4.1).

The compiler may neither fuse nor split on its own, so that a kernel gives the same bits whenever
and for whatever processor it is compiled. LLVM vectorises the intrinsic; a processor without the
instruction calls the library's, which is slow and gives the same value.
"""

from __future__ import annotations

import math

from numba import config
from numba.core import types
from numba.extending import intrinsic


def exact_fma(x, y, z):
    """x·y + z of floats, rounded once, without the instruction: by integers, which are exact."""
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
def _fused(typingctx, x, y, z):
    if not all(isinstance(v, types.Float) for v in (x, y, z)):
        return None

    def generate(context, builder, signature, args):
        return builder.fma(*args)

    double = types.float64
    return double(double, double, double), generate


fma = exact_fma if config.DISABLE_JIT else _fused
