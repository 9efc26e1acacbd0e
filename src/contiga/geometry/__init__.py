"""Exact geometry: splines, shapes, refinement, trims, bodies.

Question: where is this curve, surface or body, exactly, and how large is it? Read `knots`,
`spline`, `curve` and `surface`, `shapes`, `refine`, `bezier` (splines); `faces`, `edges`, `joints`,
`trim` (faces of a body); `quadrature` and `trim_area` (areas, volumes); `body_mesh`, `face_mesh`
and `tessellate` (the mesher); `exchange` (objects of other packages).
"""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
