"""The tables of the kernels on triangle meshes.

Triangles are in the order of the hierarchy ("slots"), so that neighbours in space are neighbours in
memory. The arrays are few and wide: a kernel takes them apart once, before its loop, because
passing a tuple of arrays to a small function costs more than the function.
"""

from __future__ import annotations

from typing import NamedTuple

from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray

NORMALS = ("facet", "vertex")
"""Kinds of normals at feet."""


@pass_by_pointer
class Facets(NamedTuple):
    """The search tables of a mesh of m triangles with an area and v merged vertices."""

    shape: FloatArray
    """(m, 18) first corner a, duals g1 and g2, unit normal n, corners b and c: barycentric
    coordinates of a point P are (P − a)·g1 and (P − a)·g2, its height is (P − a)·n."""
    link: IntArray
    """(m, 8) slots across the three edges (`NO_TRIANGLE`, or −2 − number in `around` where more
    than two meet), the three vertices, the triangle of the mesh."""
    corner: FloatArray
    """(v, 4) unit sums of the normals around a vertex, weighted by angle; 1 at a border, else 0."""
    around_first: IntArray
    around: IntArray
    """around[around_first[k] : around_first[k + 1]] are the slots around vertex k, and from
    number v on the slots that meet at a crowded edge."""
    box: FloatArray
    """(k, 6 · WIDTH) boxes of each node's children: low x of all, low y, … high z."""
    child: IntArray
    """(k, WIDTH) node, −1 − slot of a triangle, or NOBODY."""
    scale: FloatArray
    """(2,) size of the mesh, and length below which two points are one."""
