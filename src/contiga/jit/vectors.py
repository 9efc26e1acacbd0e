"""How many numbers a vector holds in kernels: what of their constants depends on the processor."""

from __future__ import annotations

from collections.abc import Sequence

Target = Sequence[str]
"""What numba compiles for: system, processor, and features of processors, as ``+avx2,-avx512f``."""
WHOLE_VECTORS = "-prefer-256-bit"
"""The feature by which LLVM makes vectors of 512 bits for processors of several makers."""


def numbers_in_vector(target: Target) -> int:
    """Eight where the compiler makes vectors of 512 bits, four elsewhere.

    It does for AMD's processors that have them; for Intel's it takes 256 bits, as their clocks may
    slow down otherwise.
    """
    _, name, features = target
    of_amd = name.startswith("znver") and "+avx512f" in features
    return 8 if of_amd or WHOLE_VECTORS in features else 4
