"""Records of cells of elements, of their smooth blocks, and of the bounds of their balls."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.elements.element_arrays import Elements
from contiga.geometry.kernels.trim_nb import TrimTables
from contiga.records import FloatArray, IntArray

CELL = np.dtype(
    [
        ("element", "i4"),
        ("patch", "i4"),
        ("block", "i4"),  # its smooth block
        ("cap", "i4"),  # the cap that it is part of, −1 for none
        ("state", "i4"),  # OUT, IN or CUT, by the trims
        ("box", "f8", 4),  # s0, s1, t0, t1
        ("uv", "f8", 4),
        ("wide", "f8", 2),  # in u and v
        ("corner", "f8", (4, 3)),  # (s0, t0), (s0, t1), (s1, t0), (s1, t1)
        ("middle", "f8", 3),
        ("normal", "f8", 3),
        ("first", "f8", (2, 3)),  # derivatives at the middle, per cell
        ("metric", "f8", 3),  # r11, r12, r22
        ("second", "f8", 3),  # bounds of |S_xx|, |S_xy|, |S_yy|
        ("change", "f8", 2),  # largest change of the derivatives from those of the middle
        ("slide", "f8", 3),  # bounds of the parts of `second` along the tangent plane
        ("corner_normal", "f8", (4, 3)),
        ("wobble", "f8"),  # distance of normals from the bilinear patch of those at corners
        ("form", "f8", 6),  # least and largest n·S_xx, n·S_xy, n·S_yy
        ("bulge", "f8"),  # distance of the surface from the bilinear patch of its corners
        ("rise", "f8"),  # largest height of the surface above that patch, along the normal
        ("sink", "f8"),  # largest depth of the surface below it
        ("turn", "f8"),  # largest relative change of the derivatives
        ("shear", "f8"),  # largest part of that change along the tangent plane of the middle
        ("tilt", "f8"),  # sine of the largest angle between normals and the middle's
        ("bend", "f8", 2),  # least and largest normal curvature, positive towards the normal
        ("extent", "f8"),  # about half its diagonal
    ],
    align=True,
)

BLOCK = np.dtype(
    [
        ("patch", "i4"),
        ("uv", "f8", 4),  # u0, u1, v0, v1 of the smooth block around a cell
        ("period", "f8", 2),  # of the patch, zero where it is not closed
        ("radii", "f8", 2),  # radii of inner and outer ball by the block alone
        ("cap", "i4"),  # the block is this cap, or that of `uv` if −1
    ],
    align=True,
)


class CellTree(NamedTuple):
    """The cells of a body, and a tree of boxes over its leaves that are not trimmed away."""

    cells: NDArray[Any]
    """(n,) `CELL`."""
    tree: NDArray[Any]
    """`NODE`, the root first."""
    order: IntArray
    """Cells in the order of the leaves."""


class CentredSurface(NamedTuple):
    """The elements and trims of a body, and the centre that lengths are measured about."""

    elements: Elements
    trims: TrimTables
    centre: FloatArray
    """(3,)."""


class BallLimits(NamedTuple):
    """Radii up to which balls are computed."""

    size: float
    """Size of the body, length."""
    cap: float
    """Largest radius, length; a larger one is of no use."""
    goal: float
    """Radius that is worth a loss of smaller ones, length."""


class CellBounds(NamedTuple):
    """Results of cells: their radii, and the unproved shares."""

    rows: NDArray[np.integer[Any]]
    """Cells that are to be bounded."""
    value: FloatArray
    """(n, 2, 4) radii inside and outside at the corners."""
    unproved: FloatArray
    """(n,) share of the samples with less than half of the possible radius."""


class Samples(NamedTuple):
    """Places of a cell, and upper bounds of the balls there."""

    point: FloatArray
    """(m, 3)."""
    normal: FloatArray
    """(m, 3)."""
    above: FloatArray
    """(m, 4) upper bounds of the radius inside and outside, and the place in the cell, in [0,
    1]²."""


class PlaneWork(NamedTuple):
    """Work arrays for planes that separate two cells."""

    trial: FloatArray
    """(4,) corner values by a plane."""
    plane: FloatArray
    """(3,) normal of the plane."""
    axis: FloatArray
    """(3,) direction in the tangent plane that best separates the cells."""
    best: FloatArray
    """(4,) the best corner values so far."""
    slopes: FloatArray
    """(6,) tilts of the planes."""
