"""Bézier elements of a set of faces: tables, evaluation, bounds, neighbours."""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
