"""How many numbers a vector of the processor holds that kernels are compiled for."""

from __future__ import annotations

from numba.core.registry import cpu_target


def numbers_in_vector() -> int:
    """Eight where the compiler makes vectors of 512 bits, four elsewhere.

    It does for AMD's processors that have them; for Intel's it takes 256 bits, as their clocks may
    slow down otherwise.
    """
    _, name, features = cpu_target.target_context.codegen().magic_tuple()
    return 8 if name.startswith("znver") and "+avx512f" in features else 4
