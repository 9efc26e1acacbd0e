"""Find where contact ends on the edges of facets that touch in part."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.area.kernels import facet_area_nb, touch_nb
from contiga.area.method import AreaInput
from contiga.area.offset import off_surface
from contiga.area.regions import Topology
from contiga.masters.protocol import Surface
from contiga.records import (
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    empty_projection,
    rows_of,
    stacked,
)
from contiga.statuses import Status

# How exactly is known where on an edge the foot leaves the master: a share of its length.
EXACT = 1e-9
# Steps to it at most: two for each halving, where the places that are looked at first tell nothing.
STEPS = 62


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
    """The places where facets that touch in part are cut."""

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
    triangles, *numbered = touch_nb.around(topology.facets, part, inp.points, place)
    return Parts(topology.facets[triangles], *numbered)


def cut_parts(inp: AreaInput, parts: Parts) -> Cut:
    """Find where contact ends on the edges of facets that touch in part."""
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
        if inp.half is not None:
            out = off_surface(out, points, inp.half[parts.free])
    return stacked(near, out)


def _ends(
    nodes: IntArray, corner: IntArray, border: np.ndarray, n_c: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Return for edges the row of the foot in contact, the node in contact, and the other node."""
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
    """Find on edges the last point whose foot is on the surface and inside; its feet.

    Beyond it the foot stays on the border, and how far the point's normal misses it grows evenly
    from zero: two such points tell where it starts.
    """
    inner, near, far = ends
    last = rows_of(feet, inner)
    low, high = np.zeros(len(border)), np.ones(len(border))
    a, way = inp.points[near], inp.points[far] - inp.points[near]
    misses = _Misses.none(len(border))
    for _ in range(STEPS):
        rows = np.flatnonzero(high - low > EXACT)
        if len(rows) == 0:
            break
        t = misses.start(rows, low[rows], high[rows])
        p_B = a[rows] + t[:, None] * way[rows]
        out = empty_projection(len(rows))
        surface.track(p_B, last.patch[rows], last.uv[rows], out)
        if inp.half is not None:
            here, there = inp.half[near[rows]], inp.half[far[rows]]
            out = off_surface(out, p_B, here + t * (there - here))
        good = (out.status == Status.OK) & (out.gap <= 0.0)
        low[rows[good]], high[rows[~good]] = t[good], t[~good]
        misses = misses.after(rows, t, np.where(good, np.nan, _miss(p_B, out)))
        for name in Projection._fields:
            getattr(last, name)[rows[good]] = getattr(out, name)[good]
    fraction[border] = low
    return last


class _Misses(NamedTuple):
    """The last two points of each edge whose feet were on the border."""

    t: FloatArray
    """(e, 2) where they lie, the later one first."""
    miss: FloatArray
    """(e, 2) how far their normals miss them, NaN where there is none yet."""
    inside: NDArray[np.bool_]
    """(e,) whether the last point asked for was on the surface."""
    left: FloatArray
    """(e, 2) what was left of each edge before the last two steps, the later one first."""

    @classmethod
    def none(cls, edges: int) -> _Misses:
        return cls(
            np.zeros((edges, 2)),
            np.full((edges, 2), np.nan),
            np.zeros(edges, np.bool_),
            np.full((edges, 2), 4.0),
        )

    def start(self, edges: IndexArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the next parameters to look at on the edges `edges`.

        They lie beside the place where misses start, on the side that was not looked at last, or in
        the middle of the rest if two steps have not halved it.
        """
        (t, before), (miss, more) = self.t[edges].T, self.miss[edges].T
        with np.errstate(divide="ignore", invalid="ignore"):
            place = t - miss * (before - t) / (more - miss)
        beside = np.maximum(1e-3 * (high - low), 0.4 * EXACT)
        place += np.where(self.inside[edges], beside, -beside)
        quick = high - low < 0.5 * self.left[edges, 1]
        self.left[edges] = np.stack([high - low, self.left[edges, 0]], axis=1)
        known = (place > low) & (place < high) & quick
        return np.where(known, place, 0.5 * (low + high))

    def after(self, edges: IndexArray, t: FloatArray, miss: FloatArray) -> _Misses:
        """With the points `t` of the edges `edges`, whose normals miss by `miss`; NaN inside."""
        outside = ~np.isnan(miss)
        rows = edges[outside]
        places, misses, inside = self.t.copy(), self.miss.copy(), self.inside.copy()
        places[rows] = np.stack([t[outside], places[rows, 0]], axis=1)
        misses[rows] = np.stack([miss[outside], misses[rows, 0]], axis=1)
        inside[edges] = ~outside
        return _Misses(places, misses, inside, self.left)


def _miss(p_B: FloatArray, feet: Projection) -> FloatArray:
    """Return distances (e,) of points from the normals at their feet, infinite without any."""
    arm = p_B - feet.point
    off = arm - (arm * feet.normal).sum(axis=1)[:, None] * feet.normal
    length = np.sqrt(np.square(off).sum(axis=1))
    return np.where(np.isfinite(length), length, np.inf)
