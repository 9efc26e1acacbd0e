"""Where contact ends on the edges of facets that touch in part."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.area.kernels import facet_area_nb, touch_nb
from contiga.area.method import AreaInput
from contiga.area.regions import Topology
from contiga.masters.protocol import Surface
from contiga.records import (
    FloatArray,
    IntArray,
    Projection,
    empty_projection,
    rows_of,
    stacked,
)
from contiga.statuses import Status

# Halvings of an edge on which the foot leaves the master: to 1e-9 of its length.
HALVINGS = 30


class Parts(NamedTuple):
    """Facets that touch in part."""

    nodes: IntArray
    """(m, 3) corners, among all points."""
    corner: IntArray
    """(m, 3) corners, numbered: the inner ones and, after them, the free ones."""
    inner: IntArray
    """(i,) corners in contact, among the points in contact."""
    free: IntArray
    """(f,) corners out of contact, among all points."""
    start: IntArray
    """(f,) number of the nearest inner corner of each."""


class Cut(NamedTuple):
    """Where facets that touch in part are cut."""

    feet: Projection
    """Of the corners, inner ones first."""
    fraction: FloatArray
    """(m, 3) way along each edge from its end in contact."""
    border: IntArray
    """(m, 3) row in `ends` of edges on which the foot leaves the surface, or −1."""
    ends: Projection
    """Feet where it leaves."""


def parts_of(inp: AreaInput, topology: Topology, part: IntArray, place: IntArray) -> Parts:
    """The facets `part`, their corners numbered on their own."""
    found, *numbered = touch_nb.around(topology.facets, part, inp.points, place)
    return Parts(topology.facets[found], *numbered)


def cut_parts(inp: AreaInput, parts: Parts) -> Cut:
    """Where contact ends on the edges of facets that touch in part."""
    nodes, corner = parts.nodes, parts.corner
    n_i, m = len(parts.inner), len(nodes)
    surface = inp.body.surface
    feet = _feet_around(surface, inp, parts)
    fraction = np.empty((m, 3))
    border = facet_area_nb.cuts(corner, feet, n_i, fraction)
    row = np.full((m, 3), -1, np.int32)
    row.ravel()[border] = np.arange(len(border))
    ends = _leave(surface, inp, feet, _ends(nodes, corner, border, n_i), fraction.ravel(), border)
    return Cut(feet, fraction, row, ends)


def _feet_around(surface: Surface, inp: AreaInput, parts: Parts) -> Projection:
    """Feet of the inner corners, and after them those of the free ones."""
    near = rows_of(inp.feet, parts.inner)
    out = empty_projection(len(parts.free))
    if len(parts.free):
        points = np.ascontiguousarray(inp.points[parts.free])
        surface.track(points, near.patch[parts.start], near.uv[parts.start], out)
    return stacked(near, out)


def _ends(
    nodes: IntArray, corner: IntArray, border: np.ndarray, n_c: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Of edges: the row of the foot in contact, the node in contact, the node that is not."""
    facet, k = border // 3, border % 3
    a, b = (facet, k), (facet, (k + 1) % 3)
    turned = corner[b] < n_c
    inner = np.where(turned, corner[b], corner[a])
    return inner, np.where(turned, nodes[b], nodes[a]), np.where(turned, nodes[a], nodes[b])


def _leave(
    surface: Surface,
    inp: AreaInput,
    feet: Projection,
    ends: tuple[IntArray, IntArray, IntArray],
    fraction: FloatArray,
    border: np.ndarray,
) -> Projection:
    """Bisect edges for the last point whose foot is on the surface and inside; its feet."""
    inner, near, far = ends
    low, high = np.zeros(len(border)), np.ones(len(border))
    last = rows_of(feet, inner)
    if len(border) == 0:
        return last
    a, b = inp.points[near], inp.points[far]
    out = empty_projection(len(border))
    for _ in range(HALVINGS):
        t = 0.5 * (low + high)
        p_B = a + t[:, None] * (b - a)
        surface.track(p_B, last.patch, last.uv, out)
        good = (out.status == Status.OK) & (out.gap <= 0.0)
        low, high = np.where(good, t, low), np.where(good, high, t)
        for name in Projection._fields:
            getattr(last, name)[good] = getattr(out, name)[good]
    fraction[border] = low
    return last
