"""How many numbers a vector holds in the kernels of this process."""

from __future__ import annotations

from contiga.jit.prebuilt import target


def numbers_in_vector() -> int:
    """Eight where the compiler makes vectors of 512 bits, four elsewhere.

    It does for AMD's processors that have them; for Intel's it takes 256 bits, as their clocks may
    slow down otherwise.
    """
    _, name, features = target()
    return 8 if name.startswith("znver") and "+avx512f" in features else 4
