"""The tables of elements and patches that the search kernels work on.

Each element, patch, leaf or node is one record, so that a kernel gets one array instead of twenty:
to pass a tuple of twenty arrays to a small function costs more than the function.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.pointer_records import pass_by_pointer
from contiga.records import ByteArray, FloatArray, IntArray

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
        ("round", "i4", 4),  # 1 where the surface closes around a pole in one tangent plane
        ("width", "f8", 4),  # of the edge along each side where a second face joins, else 0
        ("edge_tolerance", "f8"),  # largest width of an edge or a trimming piece of the element
        ("noise", "f8"),  # rounding of a point evaluated on it
        ("origin", "f8", 3),  # all coefficients are relative to it
        ("about", "f8", 2),  # (s, t) about which its powers are expanded: see `extraction`
        ("box", "f8", 4),  # u0, u1, v0, v1
        ("cubic", "f8", 64),  # x, y, z, w as bicubics in (s, t) − about, power of s first
    ],
    align=True,
)

PATCH = np.dtype(
    [
        ("u", "i4", 2),  # range of its breaks in u
        ("v", "i4", 2),
        ("first", "i4"),  # element (i, j) is first + i*nv + j
        ("adjacent", "i4", 2),  # range in `Grid.adjacent`: itself, then the patches it touches
    ],
    align=True,
)


@pass_by_pointer
class Elements(NamedTuple):
    """Bézier elements of all patches, in local coordinates (s, t) in [-1/2, 1/2]²."""

    table: Records
    """(n,) `ELEMENT`."""
    coefs: FloatArray
    """Flat coefficients: [start + (i*(q+1) + j)*4 + c] of the powers i, j of (s, t) − about (or of
    the Bernstein polynomials i, j) for the homogeneous component c (w·x, w·y, w·z, w)."""


@pass_by_pointer
class Grid(NamedTuple):
    """The place of each patch's elements among all, and the patches that touch."""

    patches: Records
    """(patches,) `PATCH`."""
    breaks: FloatArray
    """Parameters of the sides of elements, first those in u, then in v, patch by patch."""
    adjacent: IntArray
    """Numbers of patches: each patch itself and then those it touches, patch by patch."""
    loose: ByteArray
    """For each entry of `adjacent`: 1 where the two meet at an edge without lining up element by
    element, else 0."""
