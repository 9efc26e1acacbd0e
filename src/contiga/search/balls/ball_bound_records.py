"""What the kernels hand each other that bound touching balls: records of arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.elements.element_arrays import Elements
from contiga.geometry.kernels.trim_nb import TrimTables
from contiga.records import FloatArray, IntArray


class CellTree(NamedTuple):
    """The cells of a body, and a tree of boxes over those that count."""

    cells: NDArray[Any]
    """(n,) `CELL`."""
    tree: NDArray[Any]
    """Its nodes."""
    order: IntArray
    """Cells in the order of the leaves."""


class CentredSurface(NamedTuple):
    """What is measured of a body, about its centre."""

    elements: Elements
    trims: TrimTables
    centre: FloatArray
    """(3,)."""


class BallLimits(NamedTuple):
    """How large balls are asked for."""

    size: float
    """Of the body, length."""
    cap: float
    """Radius that is as good as any larger one."""
    goal: float
    """Radius that is worth a loss of smaller ones."""


class CellBounds(NamedTuple):
    """What is worked out of cells."""

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
