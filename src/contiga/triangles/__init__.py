"""Triangle meshes: what they are made of, what is wrong with them, and the search on them."""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
