"""Records of cells of elements, and of the smooth blocks about them."""

from __future__ import annotations

import numpy as np

CELL = np.dtype(
    [
        ("element", "i4"),
        ("patch", "i4"),
        ("home", "i4"),  # its smooth block
        ("cap", "i4"),  # of which it is part, −1 where it is of none
        ("state", "i4"),  # OUT, IN or CUT by the trims
        ("box", "f8", 4),  # s0, s1, t0, t1
        ("uv", "f8", 4),
        ("wide", "f8", 2),  # in u and v
        ("corner", "f8", (4, 3)),  # (s0, t0), (s0, t1), (s1, t0), (s1, t1)
        ("middle", "f8", 3),
        ("normal", "f8", 3),
        ("first", "f8", (2, 3)),  # derivatives at the middle, per cell
        ("metric", "f8", 3),  # r11, r12, r22
        ("second", "f8", 3),  # |S_xx|, |S_xy|, |S_yy| at most
        ("change", "f8", 2),  # how far the derivatives are from the middle's, at most
        ("slide", "f8", 3),  # and of their parts along the tangent plane of the middle
        ("corner_normal", "f8", (4, 3)),
        ("wobble", "f8"),  # how far normals leave the bilinear patch of the corners' normals
        ("form", "f8", 6),  # least and largest n·S_xx, n·S_xy, n·S_yy
        ("bulge", "f8"),  # how far the surface leaves the bilinear patch of its corners
        ("rise", "f8"),  # and how far above and below it, along the normal
        ("sink", "f8"),
        ("turn", "f8"),  # derivatives differ from the middle's by at most this share,
        ("shear", "f8"),  # and this much along its tangent plane
        ("tilt", "f8"),  # sine of the largest angle between normals and the middle's
        ("bend", "f8", 2),  # least and largest normal curvature, positive towards the normal
        ("extent", "f8"),  # about half its diagonal
    ],
    align=True,
)

HOME = np.dtype(
    [
        ("patch", "i4"),
        ("uv", "f8", 4),  # the smooth block around a cell
        ("period", "f8", 2),  # of the patch, zero where it does not close
        ("near", "f8", 2),  # inner and outer ball as the block alone bounds them
        ("cap", "i4"),  # the block is this cap, or the one of `uv` where it is −1
    ],
    align=True,
)
