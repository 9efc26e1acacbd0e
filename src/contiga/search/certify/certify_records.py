"""What the certificates of tracked feet hand each other: records of arrays, made by kernels."""

from __future__ import annotations

from typing import NamedTuple

from contiga.elements.element_arrays import Elements
from contiga.records import FloatArray, IndexArray, IntArray


class Near(NamedTuple):
    """What proofs on one side of an edge read of the tables: to hand on all of these costs as much
    as a proof."""

    elements: Elements
    rings: FloatArray
    """What is kept around the parts of elements."""
    trimmed: IntArray
    """(patches,) 1 where a patch is trimmed."""
    tolerance: float
    """Length."""


class Bending(NamedTuple):
    """What `bend_bounds` leaves of the cell it was asked for last."""

    derivatives: FloatArray
    """(4, 6) S and its derivatives to the second order in the middle, by parameters that run over
    [-1, 1] in the cell."""
    rest: FloatArray
    """(2, 5) what they depart from that polynomial by over the cell, at most; along the normal."""


class Cells(NamedTuple):
    """The cells about a foot that a proof is made with."""

    here: FloatArray
    """(6,) bounds of the cell about the foot, by `bend_nb`'s names of columns."""
    beyond: FloatArray
    """(6,) those of the cell that goes on across a side or an edge."""
    derivatives: FloatArray
    """(4, 6) work: S and its derivatives somewhere."""
    bending: Bending
    """Of the cell about the foot."""
    bending_beyond: Bending
    boxes: FloatArray
    """(2, 5) element (−1 none), middle s and t, half the cell in s and t: both cells, for which a
    proof holds if nothing is trimmed away from them."""


class Strand(NamedTuple):
    """The stretches of one edge in a cell, as Bézier curves in its parameters."""

    coefs: FloatArray
    """(stretches, DEGREE, 3) homogeneous x, y, w."""
    degree: IndexArray
    """(stretches,)."""


class EdgeWork(NamedTuple):
    """The cells on both sides of an edge, its strand in the first, and a place to search into."""

    cells: Cells
    strand: Strand
    place: FloatArray
    """(4,) what `closest` finds."""
