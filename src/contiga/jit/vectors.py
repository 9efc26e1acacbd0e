"""Width of vectors in kernels: some of their constants depend on the processor."""

from __future__ import annotations

from collections.abc import Sequence

Target = Sequence[str]
"""Target of numba: system, processor, and features, such as ``+avx2,-avx512f``."""
WHOLE_VECTORS = "-prefer-256-bit"
"""Feature by which LLVM uses vectors of 512 bits for processors of several makers."""


def numbers_in_vector(target: Target) -> int:
    """Return the numbers per vector: eight with vectors of 512 bits, else four.

    LLVM uses 512 bits on processors of AMD that have them; on Intel's it takes 256 bits, because
    their clock may slow down otherwise.
    """
    _, name, features = target
    of_amd = name.startswith("znver") and "+avx512f" in features
    return 8 if of_amd or WHOLE_VECTORS in features else 4
