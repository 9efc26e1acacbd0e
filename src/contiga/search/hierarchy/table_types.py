"""The tables the search kernels work on, beside the elements.

One record a leaf or a node: a kernel is handed one array instead of twenty (handing a tuple of
twenty arrays to a small function costs more than the function).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.elements.element_arrays import Elements, Grid, Records
from contiga.geometry.trim import TrimTables
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray

NEIGHBOURHOOD = np.dtype(
    [
        # Over a part of an element and those around it (see `neighbourhood_nb`):
        ("curvature", "f8", 2),  # largest towards the normal and away from it, each 0 at least
        ("room", "f8"),  # a way shorter than this does not lead out of them
        ("speed", "f8", 2),  # |S_u|, |S_v| at most, within `block`
        ("width", "f8", 2),  # part of S_u across S_v, of S_v across S_u at least
        ("block", "f8", 4),  # u0, u1, v0, v1 around the part
        ("ends", "i1", 4),  # 1 where the element's side is not smooth and within reach
        ("reach", "i1", 4),  # parts of the element across each side that are among them
        ("pole", "i1"),  # side that is a pole within reach, -1 none
    ],
    align=True,
)
LEAF = np.dtype(
    [
        ("element", "i4"),  # surface leaf: its element; curve leaf: -1 - trimming piece
        ("patch", "i4"),
        ("has_form", "i4"),  # 1 where it is all of an element that has a form
        ("box", "f8", 4),  # s0, s1, t0, t1; curve leaf: t0, t1 of the piece
        # |S_s|, |S_t|, |S_ss|, |S_st|, |S_tt|, |S_sss|, |S_sst|, |S_stt|, |S_ttt| at most; curve
        # leaf: |C'|, |C''|, |C'''|, the way into the face in its middle (3), how far it is off,
        # 1 where the face is to the left of the piece, -1 to the right, 0 where that is not known,
        # the sine of the largest turn of its normal
        ("bound", "f8", 9),
    ],
    align=True,
)
PLATE = np.dtype(
    [
        # A leaf laid flat (see `plates_nb`):
        ("middle", "f8", 3),
        ("x", "f8", 3),  # from there to the middles of two sides; of a curve leaf the second is 0
        ("y", "f8", 3),
        ("metric", "f8", 3),  # products x x, x y, y y
        ("departure", "f8"),  # how far the leaf leaves it at most
        ("spare", "f8"),  # how far the body is from its middle: infinite where that is trimmed away
        ("normal", "f8", 3),  # of length one, or zero where the plate has none
        ("radius", "f8"),  # no point of the leaf is farther from the middle
        ("edge_tolerance", "f8"),  # how far beyond its edges the leaf's face may be met
    ],
    align=True,
)
FORM = np.dtype(
    [
        # An element whose closest point is a formula (see `forms`, `form_nb`):
        ("kind", "i4"),
        ("turned_along_t", "i4"),  # 1 where t runs around the axis and s along the meridian
        ("origin", "f8", 3),  # middle of a plane; else on the axis
        ("x", "f8", 3),  # half sides of a plane; else unit vectors to the middle of the turn
        ("y", "f8", 3),  # and along its chord
        ("z", "f8", 3),  # unit normal of a plane; else the axis
        ("metric", "f8", 3),  # of a plane: products x x, x y, y y
        # Half the angle: cosine, sine; tangent of its half; root of the ratio of weights
        ("turn", "f8", 4),
        ("about", "f8", 2),  # (away from the axis, along it): a line's start, an arc's center
        ("toward", "f8", 2),  # unit vectors along a line, or to the middle of an arc
        ("across", "f8", 2),  # and along an arc's chord
        ("radius", "f8"),  # of an arc; length of a line
        ("meridian", "f8", 4),  # as `turn`; of a line the last number, the ratio of weights, alone
    ],
    align=True,
)
NODE = np.dtype(
    [
        ("low", "f8", 3),
        ("high", "f8", 3),
        ("first", "i4"),  # first leaf; of an inner node (count 0) the left child, right is +1
        ("count", "i4"),
    ],
    align=True,
)


@pass_by_pointer
class Seeds(NamedTuple):
    """A leaf near every voxel of a grid over the body: where to look for a closest point first."""

    low: FloatArray
    """(3,) corner of the grid."""
    scale: FloatArray
    """(1,) voxels a length."""
    voxels: IntArray
    """(3,) how many along each axis."""
    leaf: IntArray
    """(voxels,) the leaf, −1 where nobody has asked yet."""


@pass_by_pointer
class Items(NamedTuple):
    """The items that the closest point is searched among.

    They are elements that have a form, each whole, and the leaves of all else.

    Of a body without forms these are its leaves.
    """

    leaves: Records
    """`LEAF`, in the order of the hierarchy."""
    plates: Records
    """`PLATE` of each; of an element that has a form it says nothing."""
    tree: Records
    """`NODE`, the root first."""
    forms: Records
    """(elements,) `FORM`; of a body without forms there are none."""


@pass_by_pointer
class Tables(NamedTuple):
    """Everything the kernels are handed about a body."""

    elements: Elements
    grid: Grid
    leaves: Records
    """`LEAF`, in the order of the hierarchy."""
    plates: Records
    """`PLATE` of each leaf."""
    tree: Records
    """`NODE`, the root first."""
    items: Items
    seeds: Seeds
    trims: TrimTables
    piece_open: FloatArray
    """(pieces,) 1 where a trimming piece bounds the body (no second face uses its edge)."""
    piece_width: FloatArray
    """(pieces,) width of the edge along a trimming piece, length; 0 where no second face joins."""
    scale: FloatArray
    """(2,) size of the body, tangential tolerance of a foot; lengths."""
    neighbourhoods: Records
    """(elements, 16) `NEIGHBOURHOOD`, of no elements but where tracked feet are certified."""
