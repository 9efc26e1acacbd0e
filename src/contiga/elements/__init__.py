"""Bézier elements of a set of faces: tables, evaluation, bounds, neighbours.

Question: into which polynomials does a set of faces fall, and which lie side by side? Read
`extraction`, `element_arrays` (the tables that kernels get), `neighbours`, `refit` (control points
that move).
"""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
