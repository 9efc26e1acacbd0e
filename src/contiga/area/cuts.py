"""Find where contact ends on the edges of facets that touch in part."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.area.kernels import facet_area_nb, touch_nb
from contiga.area.method import AreaInput
from contiga.area.offset import off_surface
from contiga.area.regions import Topology
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

# Tolerance of the place on an edge where the foot leaves the master, as a share of its length.
EDGE_TOL = 1e-9
# Largest number of steps to it: two for each halving, where the secant steps do not help.
MAX_STEPS = 62


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
    """Feet of the corners, inner ones first."""
    fraction: FloatArray
    """(m, 3) place on each edge, as a fraction of it from its end in contact."""
    border: IntArray
    """(m, 3) row in `ends` of edges on which the foot leaves the surface, or −1."""
    ends: Projection
    """Feet at the places where they leave."""


def parts_of(inp: AreaInput, topology: Topology, part: IntArray, place: IntArray) -> Parts:
    """Return the facets `part` whose corners are finite, with a numbering of their corners.

    `place` (n,) is the index of each point among the points in contact, or −1.
    """
    triangles, *numbering = touch_nb.around(topology.facets, part, inp.points, place)
    return Parts(topology.facets[triangles], *numbering)


def cut_parts(inp: AreaInput, parts: Parts) -> Cut:
    """Return where contact ends on the edges of facets that touch in part.

    Feet of corners out of contact are continued from the nearest corner in contact. An edge is cut
    where the gap, linear along it, is zero; where the foot leaves the surface, by a search.
    """
    # The feet of the inner corners, and after them those of the free ones.
    inner_feet = rows_of(inp.feet, parts.inner)
    free_feet = empty_projection(len(parts.free))
    if len(parts.free):
        p_B = np.ascontiguousarray(inp.points[parts.free])
        start = parts.start
        inp.body.surface.track(p_B, inner_feet.patch[start], inner_feet.uv[start], free_feet)
        if inp.half is not None:
            free_feet = off_surface(free_feet, p_B, inp.half[parts.free])
    feet = stacked(inner_feet, free_feet)
    m = len(parts.nodes)
    fraction = np.empty((m, 3))
    border = facet_area_nb.cuts(parts.corner, feet, len(parts.inner), fraction)
    row_of_edge = np.full((m, 3), -1, np.int32)
    row_of_edge.ravel()[border] = np.arange(len(border))
    fraction.ravel()[border], ends = _leaving_points(inp, parts, feet, border)
    return Cut(feet, fraction, row_of_edge, ends)


def _leaving_points(
    inp: AreaInput, parts: Parts, feet: Projection, edges: np.ndarray
) -> tuple[FloatArray, Projection]:
    """Return the last point of each edge whose foot is on the surface and whose gap is ≤ 0.

    Beyond that point the foot stays on the border, and the distance of the point from the normal at
    its foot grows linearly from zero, so that a secant step finds where it starts. The point is the
    inner end of a bracket of `EDGE_TOL`, or what `MAX_STEPS` steps leave.

    Parameters
    ----------
    feet : of the corners, inner ones first
    edges : (e,) facet * 3 + k for the edge from corner k to corner k + 1

    Returns
    -------
    fraction : (e,) place on each edge, from its end in contact
    ends : (e,) feet there
    """
    facet, k = edges // 3, edges % 3
    a, b = (facet, k), (facet, (k + 1) % 3)
    is_reversed = parts.corner[b] < len(parts.inner)
    last = rows_of(feet, np.where(is_reversed, parts.corner[b], parts.corner[a]))
    inner = np.where(is_reversed, parts.nodes[b], parts.nodes[a])
    outer = np.where(is_reversed, parts.nodes[a], parts.nodes[b])
    low, high = np.zeros(len(edges)), np.ones(len(edges))
    origin, vector = inp.points[inner], inp.points[outer] - inp.points[inner]
    history = _SecantHistory.empty(len(edges))
    for _ in range(MAX_STEPS):
        rows = np.flatnonzero(high - low > EDGE_TOL)
        if len(rows) == 0:
            break
        t = history.next_t(rows, low[rows], high[rows])
        p_B = origin[rows] + t[:, None] * vector[rows]
        trial = empty_projection(len(rows))
        inp.body.surface.track(p_B, last.patch[rows], last.uv[rows], trial)
        if inp.half is not None:
            half = inp.half[inner[rows]]
            trial = off_surface(trial, p_B, half + t * (inp.half[outer[rows]] - half))
        is_inside = (trial.status == Status.OK) & (trial.gap <= 0.0)
        low[rows[is_inside]], high[rows[~is_inside]] = t[is_inside], t[~is_inside]
        arm = p_B - trial.point
        off_normal = arm - (arm * trial.normal).sum(axis=1)[:, None] * trial.normal
        offset = np.sqrt(np.square(off_normal).sum(axis=1))
        offset[~np.isfinite(offset)] = np.inf
        history.add(rows, t, offset, is_inside)
        for name in Projection._fields:
            getattr(last, name)[rows[is_inside]] = getattr(trial, name)[is_inside]
    return low, last


class _SecantHistory(NamedTuple):
    """The last two points of each edge whose feet were on the border."""

    t: FloatArray
    """(e, 2) their places on the edge, the later one first."""
    offset: FloatArray
    """(e, 2) their distances from the normals at their feet, NaN where there is no point yet."""
    was_inside: NDArray[np.bool_]
    """(e,) whether the last trial point was on the surface."""
    width: FloatArray
    """(e, 2) widths of the bracket before the last two steps, the later one first."""

    @classmethod
    def empty(cls, edges: int) -> _SecantHistory:
        return cls(
            np.zeros((edges, 2)),
            np.full((edges, 2), np.nan),
            np.zeros(edges, np.bool_),
            np.full((edges, 2), 4.0),
        )

    def next_t(self, edges: IndexArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the next places (k,) to try on `edges` (k,), as fractions of them.

        They lie next to the zero of the secant, on the other side of it than the last trial, or in
        the middle of the bracket if two steps have not halved it, or the zero is outside. The
        widths of the brackets are recorded in `width`.
        """
        (t, t_before), (offset, offset_before) = self.t[edges].T, self.offset[edges].T
        with np.errstate(divide="ignore", invalid="ignore"):
            zero = t - offset * (t_before - t) / (offset_before - offset)
        margin = np.maximum(1e-3 * (high - low), 0.4 * EDGE_TOL)
        zero += np.where(self.was_inside[edges], margin, -margin)
        is_fast = high - low < 0.5 * self.width[edges, 1]
        self.width[edges] = np.stack([high - low, self.width[edges, 0]], axis=1)
        return np.where((zero > low) & (zero < high) & is_fast, zero, 0.5 * (low + high))

    def add(
        self, edges: IndexArray, t: FloatArray, offset: FloatArray, is_inside: NDArray[np.bool_]
    ) -> None:
        """Add the trial points `t` of `edges`; `offset` counts for points that are not inside."""
        rows = edges[~is_inside]
        self.t[rows] = np.stack([t[~is_inside], self.t[rows, 0]], axis=1)
        self.offset[rows] = np.stack([offset[~is_inside], self.offset[rows, 0]], axis=1)
        self.was_inside[edges] = is_inside
