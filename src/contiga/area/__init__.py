"""Contact area of the points that touch."""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
