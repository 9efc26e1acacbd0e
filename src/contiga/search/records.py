"""The tables the search kernels work on.

One record an element, a patch, a leaf or a node: a kernel is handed one array instead of twenty
(handing a tuple of twenty arrays to a small function costs more than the function).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.trim import TrimTables
from contiga.records import ByteArray, FloatArray, IntArray

# Kinds of element side.
SMOOTH = 0  # another element continues the surface with the same tangent plane
CREASE = 1  # another element continues the surface with a kink
BORDER = 2  # the surface ends
POLE = 3  # the whole side is one point
SHARED = 4  # a face joins here whose elements do not line up with this one's

# States of an element against the trimming loops (as `box_state` of the trims returns them).
OUT, IN, CUT = 0, 1, 2

# Form an element is evaluated in.
GENERAL, CUBIC, RATIONAL_CUBIC = 0, 1, 2

Records = NDArray[Any]

ELEMENT = np.dtype(
    [
        ("patch", "i4"),
        ("form", "i4"),  # GENERAL, CUBIC, RATIONAL_CUBIC
        ("degree", "i4", 2),
        ("components", "i4"),  # 3 polynomial, 4 rational
        ("monomial", "i4"),  # where its monomials start in `coefs`, -1 above their degree
        ("bernstein", "i4"),  # where its Bernstein coefficients start in `coefs`
        ("trim", "i4"),  # OUT, IN, CUT
        ("kind", "i4", 4),  # of the sides s = -1/2, s = 1/2, t = -1/2, t = 1/2
        ("neighbour", "i4", 4),  # element across each side, -1 none
        ("neighbour_side", "i4", 4),  # that element's side
        ("flip", "i4", 4),  # 1 where the side's parameter runs the other way there
        ("ring", "i4", 4),  # next of the sides (element*4 + side) around the same pole
        ("width", "f8", 4),  # of the edge along each side where a second face joins, else 0
        ("skirt", "f8"),  # largest width of an edge or a trimming piece of the element
        ("noise", "f8"),  # rounding of a point evaluated on it
        ("origin", "f8", 3),  # all coefficients are relative to it
        ("box", "f8", 4),  # u0, u1, v0, v1
        ("cubic", "f8", 64),  # x, y, z, w as bicubics in (s, t), power of s first
    ],
    align=True,
)

PATCH = np.dtype(
    [
        ("u", "i4", 2),  # first and one past the last of its breaks in u
        ("v", "i4", 2),
        ("first", "i4"),  # element (i, j) is first + i*nv + j
        ("adjacent", "i4", 2),  # range in `Grid.adjacent`: itself, then the patches it touches
    ],
    align=True,
)

RING = np.dtype(
    [
        # Over a part of an element and those around it (see `_ring_nb`):
        ("curvature", "f8", 2),  # largest towards the normal and away from it, each 0 at least
        ("room", "f8"),  # a way shorter than this does not lead out of them
        ("speed", "f8", 2),  # |S_u|, |S_v| at most, within `block`
        ("width", "f8", 2),  # part of S_u across S_v, of S_v across S_u at least
        ("block", "f8", 4),  # u0, u1, v0, v1 around the part
        ("ends", "i4", 4),  # 1 where the element's side is not smooth and within reach
        ("pole", "i4"),  # side that is a pole within reach, -1 none
    ],
    align=True,
)

JOINT = np.dtype(
    [
        ("patch", "i4", 2),  # the two faces of an edge; -1 where nothing is known of how they meet
        ("width", "f8"),  # of the edge, length
        ("turn", "f8"),  # largest angle between their normals along it, radians, as measured
        ("slip", "f8"),  # largest angle between its tangent in one and the other's plane, likewise
    ],
    align=True,
)

LEAF = np.dtype(
    [
        ("element", "i4"),  # surface leaf: its element; curve leaf: -1 - trimming piece
        ("patch", "i4"),
        ("box", "f8", 4),  # s0, s1, t0, t1; curve leaf: t0, t1 of the piece
        # |S_s|, |S_t|, |S_ss|, |S_st|, |S_tt|, |S_sss|, |S_sst|, |S_stt|, |S_ttt| at most
        ("bound", "f8", 9),
        ("middle", "f8", 3),  # a point of the body in it; infinite where that is trimmed away
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


class Elements(NamedTuple):
    """Bézier elements of all patches, in local coordinates (s, t) in [-1/2, 1/2]²."""

    table: Records
    """(n,) `ELEMENT`."""
    coefs: FloatArray
    """Flat coefficients: [start + (i*(q+1) + j)*4 + c] of s^i t^j (or of the Bernstein
    polynomials i, j) for the homogeneous component c (w·x, w·y, w·z, w)."""


class Grid(NamedTuple):
    """Where the elements of each patch stand, and which patches touch."""

    patches: Records
    """(patches,) `PATCH`."""
    breaks: FloatArray
    adjacent: IntArray
    loose: ByteArray
    """1 where two patches meet at an edge without lining up element by element."""


class Joints(NamedTuple):
    """Edges at which trimmed faces join others (see `trimmed_edges`)."""

    edges: Records
    """(edges,) `JOINT`."""
    sides: IntArray
    """(elements, 4) the edge that an untrimmed patch's natural side is a part of, −1 none."""


class Tables(NamedTuple):
    """Everything the kernels are handed about a body."""

    elements: Elements
    grid: Grid
    leaves: Records
    """`LEAF`, in the order of the hierarchy."""
    tree: Records
    """`NODE`, the root first."""
    trims: TrimTables
    piece_open: FloatArray
    """(pieces,) 1 where a trimming piece bounds the body (no second face uses its edge)."""
    piece_width: FloatArray
    """(pieces,) width of the edge along a trimming piece, length; 0 where no second face joins."""
    scale: FloatArray
    """(2,) size of the body, tangential tolerance of a foot; lengths."""
    rings: Records
    """(elements, 16) `RING`."""
    joints: Joints
