"""Exact geometry: splines, shapes, refinement, trims, bodies."""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
