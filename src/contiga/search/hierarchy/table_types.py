"""The tables of leaves, plates, forms and nodes that the search kernels work on.

Each leaf or node is one record, so that a kernel gets one array instead of twenty (see
`contiga.elements.element_arrays`).
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
        # Bounds over a part of an element and the parts around it (see `neighbourhood_nb`):
        ("curvature", "f8", 2),  # largest towards the normal and away from it, each at least 0
        ("room", "f8"),  # lower bound of the length of a path that leaves the parts
        ("speed", "f8", 2),  # upper bounds of |S_u|, |S_v| within `block`
        ("width", "f8", 2),  # lower bounds of the part of S_u across S_v, and of S_v across S_u
        ("block", "f8", 4),  # u0, u1, v0, v1 around the part
        ("ends", "i1", 4),  # 1 if the element's side is not smooth and within reach
        ("reach", "i1", 4),  # number of included parts of the element across each side
        ("pole", "i1"),  # side that is a pole within reach, -1 none
    ],
    align=True,
)
LEAF = np.dtype(
    [
        ("element", "i4"),  # surface leaf: its element; curve leaf: -1 - trimming piece
        ("patch", "i4"),
        ("has_form", "i4"),  # 1 if it is a complete element that has a form
        ("box", "f8", 4),  # s0, s1, t0, t1; curve leaf: t0, t1 of the piece
        # Upper bounds of |S_s|, |S_t|, |S_ss|, |S_st|, |S_tt|, |S_sss|, |S_sst|, |S_stt|, |S_ttt|;
        # curve leaf: of |C'|, |C''|, |C'''|; the inward direction in its middle (3), its largest
        # deviation, 1 if the face is to the left of the piece, -1 to the right, 0 if unknown, the
        # sine of the largest turn of the face's normal
        ("bound", "f8", 9),
    ],
    align=True,
)
PLATE = np.dtype(
    [
        # A flat copy of a leaf (see `plates_nb`):
        ("middle", "f8", 3),
        ("x", "f8", 3),  # vectors from there to the middles of two sides; curve leaf: y is 0
        ("y", "f8", 3),
        ("metric", "f8", 3),  # products x x, x y, y y
        ("departure", "f8"),  # largest distance of the leaf from it
        ("spare", "f8"),  # largest distance of the body from its middle: infinite if trimmed away
        ("normal", "f8", 3),  # unit vector, or zero if the plate has none
        ("radius", "f8"),  # largest distance of a point of the leaf from the middle
        ("edge_tolerance", "f8"),  # margin of the leaf's face beyond its edges
    ],
    align=True,
)
FORM = np.dtype(
    [
        # An element whose closest point is a formula (see `forms`, `form_nb`):
        ("kind", "i4"),
        ("turned_along_t", "i4"),  # 1 if t runs around the axis and s along the meridian
        ("origin", "f8", 3),  # middle of a plane; else on the axis
        ("x", "f8", 3),  # half side of a plane; else unit vector to the middle of the turn
        ("y", "f8", 3),  # other half side of a plane; else unit vector along the chord of the turn
        ("z", "f8", 3),  # unit normal of a plane; else the axis
        ("metric", "f8", 3),  # of a plane: products x x, x y, y y
        # Half the angle: cosine, sine; tangent of its half; root of the ratio of weights
        ("turn", "f8", 4),
        ("about", "f8", 2),  # (away from the axis, along it): a line's start, an arc's center
        ("toward", "f8", 2),  # unit vector along a line, or to the middle of an arc
        ("across", "f8", 2),  # unit vector along an arc's chord; of a line zero
        ("radius", "f8"),  # radius of an arc; length of a line
        ("meridian", "f8", 4),  # as `turn`; of a line only the last, the ratio of weights w1/w0
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
    """A leaf near every voxel of a grid over the body: first guesses of closest points."""

    low: FloatArray
    """(3,) corner of the grid."""
    scale: FloatArray
    """(1,) voxels per length."""
    voxels: IntArray
    """(3,) number of voxels along each axis."""
    leaf: IntArray
    """(voxels,) the leaf, −1 if it has not been computed yet."""


@pass_by_pointer
class Items(NamedTuple):
    """The items of the closest point search: complete elements that have a form, and other leaves.

    For a body without forms these are its leaves.
    """

    leaves: Records
    """`LEAF`, in the order of the hierarchy."""
    plates: Records
    """`PLATE` of each; undefined for an element with a form."""
    tree: Records
    """`NODE`, the root first."""
    forms: Records
    """(elements,) `FORM`; empty for a body without forms."""


@pass_by_pointer
class Tables(NamedTuple):
    """All tables of a body for kernels."""

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
    """(pieces,) 1 if a trimming piece bounds the body (no second face uses its edge)."""
    piece_width: FloatArray
    """(pieces,) width of the edge along a trimming piece, length; 0 without a second face."""
    scale: FloatArray
    """(2,) size of the body, tangential tolerance of a foot; lengths."""
    neighbourhoods: Records
    """(elements, 16) `NEIGHBOURHOOD`; empty unless tracked feet are certified."""
