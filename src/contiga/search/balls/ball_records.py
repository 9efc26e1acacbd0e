"""Records of cells of elements, of the smooth blocks about them, and of what bounds their balls."""

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


class CellTree(NamedTuple):
    """The cells of a body, and a tree of boxes over those that count."""

    cells: NDArray[Any]
    """(n,) `CELL`."""
    tree: NDArray[Any]
    """Its nodes."""
    order: IntArray
    """Cells in the order of the leaves."""


class CentredSurface(NamedTuple):
    """The elements and trims of a body, and the centre that lengths are measured about."""

    elements: Elements
    trims: TrimTables
    centre: FloatArray
    """(3,)."""


class BallLimits(NamedTuple):
    """Radii up to which balls are asked for, length."""

    size: float
    """Of the body, length."""
    cap: float
    """Radius that is as good as any larger one."""
    goal: float
    """Radius that is worth a loss of smaller ones."""


class CellBounds(NamedTuple):
    """The results for cells: radii, and what is wanting in them."""

    rows: NDArray[np.integer[Any]]
    """Cells to be done."""
    value: FloatArray
    """(n, 2, 4) radii inside and outside at the corners."""
    want: FloatArray
    """(n,) share of what may be there that is not proved."""


class Samples(NamedTuple):
    """Places of a cell, and how large a ball may be there."""

    point: FloatArray
    """(m, 3)."""
    normal: FloatArray
    """(m, 3)."""
    above: FloatArray
    """(m, 4) radius inside and outside at most, and where in the cell they are, in [0, 1]²."""


class PlaneWork(NamedTuple):
    """Memory to part a cell from another by planes."""

    trial: FloatArray
    """(4,) corner values that a plane leaves."""
    plane: FloatArray
    """(3,) its normal."""
    axis: FloatArray
    """(3,) direction in the tangent plane that parts the cells best."""
    best: FloatArray
    """(4,) the best corner values so far."""
    slopes: FloatArray
    """(6,) tilts of planes that are tried."""
