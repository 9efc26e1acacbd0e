"""Bézier elements of a set of faces: tables, evaluation, bounds, neighbours.

Question: which polynomials form a set of faces, and which of them are neighbours? Read
`extraction`, `element_arrays` (the tables that kernels get), `neighbours`, `refit` (control points
that move).
"""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
