"""One face of a body as triangles between the vertices of its border."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.bezier import extract
from contiga.geometry.kernels import border_nb
from contiga.geometry.kernels.check_nb import refine
from contiga.geometry.kernels.ears_nb import ears, one_ring
from contiga.geometry.kernels.evaluate_nb import make_scratch
from contiga.geometry.kernels.height_nb import MAX_DEPTH, Heights
from contiga.geometry.kernels.refine_nb import (
    MIN_DISTANCE_SHARE,
    Front,
    hash_vertices,
    insert_vertex,
    relax,
)
from contiga.geometry.kernels.shape_nb import Face, shapes_at
from contiga.geometry.kernels.triangulation_nb import (
    BORDER,
    FREE,
    GRID,
    N_FRAME,
    TRIANGLES,
    VERTICES,
    Triangulation,
)
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

GROWTH = 2
MAX_RELAXATIONS = 12
"""Largest number of rounds of turning sides before the first vertex goes in."""
ANY_DISTANCE = -1.0
"""Distance from other vertices at which a vertex is inserted whether it helps or not."""
INTERIOR = -1
"""Vertex of this face alone, in place of its number in the body's mesh."""


class Polygons(NamedTuple):
    """Borders of a face: closed polygons in (u, v)."""

    uv: FloatArray
    """(n, 2)."""
    ids: Ints
    """(n,) vertex of the body's mesh."""
    parts: Ints
    """(n, 2) edge of the body and number of its part from each vertex to the next."""
    starts: Ints
    """(l + 1,) first vertex of each polygon."""


class FaceMesh:
    """Triangles of a face: at first between its polygons, then refined by `refine`.

    Parameters
    ----------
    surface : the patch
    polygons : the face's border
    """

    def __init__(self, surface: NurbsSurface, polygons: Polygons) -> None:
        self.surface = surface
        self.polygons = polygons
        self.low = polygons.uv.min(axis=0)
        extent = polygons.uv.max(axis=0) - self.low
        self.extent = np.where(extent > 0.0, extent, 1.0)
        first, n = N_FRAME, len(polygons.uv)
        self.ids = np.concatenate([np.full(first, INTERIOR), polygons.ids])
        self.t = _empty_triangulation(first + n + 8)
        places = (polygons.uv - self.low) / self.extent
        self.t.xy[first : first + n] = np.round(places / GRID) * GRID
        self.ears: Ints | None = None
        self.is_crossing, self.is_valid = self._triangulate()

    def _triangulate(self) -> tuple[Flags, bool]:
        """Triangulate `t` between the polygons; return which segments (n,) cross, and success.

        Sides between two copies of one vertex (at a pole, over a gap) may vanish; others may not.
        It is no success if a segment crosses, if vertices with different numbers coincide, or if
        nothing is inside; in that last case all segments count as crossing.
        """
        t, first, n = self.t, N_FRAME, len(self.polygons.uv)
        border_nb.open_frame(t)
        t.used[VERTICES] = first + n
        # Vertices go in coarse to fine along the polygons, each from an earlier one near it.
        i = np.arange(n)
        step = np.where(i == 0, np.int64(1) << 60, i & -i)
        order = np.lexsort((i, -step))
        hint = np.where(order == 0, -1, order - step[order] + first)
        alias = np.arange(first + n)
        at = border_nb.insert_vertices(t, order + first, hint, self._mean_metric(), alias)
        loops = [np.arange(a, b) for a, b in pairwise(self.polygons.starts)]
        sides = [np.stack([loop, np.roll(loop, -1)], axis=1) for loop in loops]
        segments = np.concatenate(sides) + first
        is_double, is_bad = np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
        border_nb.recover_segments(t, at, segments, alias, is_double, is_bad)
        a, b = segments.T
        is_bad &= (alias[a] != alias[b]) | (self.ids[a] != self.ids[b])
        aliases_agree = bool((self.ids[alias] == self.ids).all())
        if is_bad.any() or not aliases_agree:
            return is_bad, False
        inside = border_nb.find_inside(t, is_double, np.empty(len(t.corners), np.int64))
        border_nb.remove_outside(t, inside)
        # If nothing is between them, as for two chords with the same ends, all cross.
        is_valid = bool(t.used[TRIANGLES] > 0)
        return is_bad if is_valid else np.ones(n, dtype=np.bool_), is_valid

    def _mean_metric(self) -> FloatArray:
        """Return (3,) the metric (E, 0, G) of mean lengths of S_u and S_v over the unit square.

        They are means of nine samples; a length is at least 1e-9 of the other.
        """
        share = np.array([0.1, 0.5, 0.9])
        uv = np.stack(np.meshgrid(share, share), axis=-1).reshape(-1, 2)
        first = self.surface.derivatives(uv * self.extent + self.low, 1)
        lengths = np.linalg.norm(np.stack([first[:, 1, 0], first[:, 0, 1]], axis=1), axis=2)
        mean = lengths.mean(axis=0) * self.extent
        mean = np.maximum(mean, 1e-9 * max(float(mean.max()), 1e-300))
        return np.array([mean[0] ** 2, 0.0, mean[1] ** 2])

    def cut_ears(self) -> None:
        """Triangulate between polygons that cross: see `ears_nb`. The face is then not refined."""
        xy = (self.polygons.uv - self.low) / self.extent
        self.ears = ears(xy, one_ring(xy, self.polygons.starts))

    def prepare(self, sag: float) -> None:
        """Compute points and curvature at the vertices so far; turn sides to fit the curvature.

        `sag` is the largest distance of triangles from the surface. Sets `face` and `front`, which
        `insert` and `refine` need.
        """
        p, q = self.surface.degrees
        frame = np.concatenate([self.low, self.extent])
        size = float(np.ptp(self.surface.evaluate(self.polygons.uv), axis=0).max())
        floor = 1.0 / max(3.0 * size * size, 1e-300)
        self.face = Face(
            self.surface.arrays, frame, sag, floor, make_scratch(p, q, 2), np.empty((3, 3, 3))
        )
        self.front = _empty_front(self.t)
        shapes_at(self.t, self.face, self.front.points, self.front.forms)
        relax(self.t, self.front, MAX_RELAXATIONS)
        hash_vertices(self.t, self.front, MIN_DISTANCE_SHARE * sag)

    def refine(self, max_triangles: int) -> bool:
        """Insert vertices until no triangle misses the surface by more than the sag of `prepare`.

        Returns True; False once there are more than `max_triangles`. Triangles too small to be
        split are left.
        """
        middle = self.surface.bounds().mean(axis=0)
        coefs, u, v = extract(self.surface.translated(-middle))
        n_stack = 3 * MAX_DEPTH + 4
        stack = np.empty((n_stack, *coefs.shape[2:4], 2))
        heights = Heights(coefs, u, v, middle, stack, np.empty((n_stack, 5)))
        while not refine(self.t, self.face, self.front, heights):
            if self.t.used[TRIANGLES] > max_triangles:
                return False
            self._grow()
        return True

    def insert(self, x: float, y: float, distance: float) -> bool:
        """Insert a vertex at (x, y) of the unit square; False on the border, outside or too near.

        `distance` is the smallest one from other vertices, in the metric; see `insert_vertex`.
        """
        if self.t.used[VERTICES] + 2 >= len(self.t.xy):
            self._grow()
        return bool(insert_vertex(self.t, self.face, self.front, 0, x, y, distance))

    def renumber(self, polygons: Polygons) -> None:
        """Replace the polygons by equal ones with other numbers of vertices."""
        self.polygons = polygons
        self.ids[N_FRAME:] = polygons.ids

    def insert_at_centre(self, triangle: int) -> bool:
        """Insert a vertex at the centre of a triangle; False if it has no room, or after ears."""
        if self.ears is not None:
            return False
        x, y = self.t.xy[self.t.corners[triangle]].mean(axis=0)
        return self.insert(x, y, ANY_DISTANCE)

    def side_middle(self, triangle: int, k: int) -> tuple[float, float] | None:
        """Return (x, y) of the middle of side k of a triangle; None on the border or after ears."""
        if self.ears is not None or self.t.neighbours[triangle, k] == BORDER:
            return None
        a, b = self.t.corners[triangle, [(k + 1) % 3, (k + 2) % 3]]
        x, y = 0.5 * (self.t.xy[a] + self.t.xy[b])
        return float(x), float(y)

    def _grow(self) -> None:
        """Move the triangulation and its front to arrays of twice the size."""
        t = _empty_triangulation(GROWTH * len(self.t.xy) + 64)
        for new, old in zip(t, self.t, strict=True):
            new[: len(old)] = old
        front = _empty_front(t)
        front.points[: len(self.t.xy)] = self.front.points
        front.forms[: len(self.t.xy)] = self.front.forms
        self.t, self.front = t, front
        hash_vertices(t, front, MIN_DISTANCE_SHARE * self.face.sag)

    def triangles(self) -> Ints:
        """Return (m, 3) vertices of this face, which number from the polygons' first one."""
        if self.ears is not None:
            return self.ears
        return self.t.corners[: self.t.used[TRIANGLES]] - N_FRAME

    def interior_points(self) -> FloatArray:
        """Return points (k, 3) of interior vertices, which follow those of the polygons."""
        if self.ears is not None:
            return np.empty((0, 3))
        return self.front.points[len(self.ids) : self.t.used[VERTICES]]


def _empty_triangulation(n: int) -> Triangulation:
    """Return memory for n vertices."""
    m = 2 * n + 8
    return Triangulation(
        np.zeros((n, 2)),
        np.zeros((m, 3), np.int64),
        np.full((m, 3), -1, np.int64),
        np.full((m, 3), FREE, np.int64),
        np.zeros(m, np.int8),
        np.zeros(2, np.int64),
    )


def _empty_front(t: Triangulation) -> Front:
    """Return memory for the front of a triangulation."""
    n, m = len(t.xy), len(t.corners)
    return Front(
        np.zeros((n, 3)),
        np.zeros((n, 7)),
        np.zeros(m, np.int64),
        np.zeros(m, np.bool_),
        np.zeros(2, np.int64),
        np.zeros(m + 8, np.int64),
        np.full(1 << n.bit_length(), -1, np.int64),
        np.zeros(n, np.int64),
    )
