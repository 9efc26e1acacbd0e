"""One face of a body as triangles over given vertices of its border."""

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
from contiga.geometry.kernels.height_nb import DEPTH, Heights
from contiga.geometry.kernels.refine_nb import USELESS, Front, enter_all, put_vertex, relax
from contiga.geometry.kernels.shape_nb import Face, shapes_at
from contiga.geometry.kernels.triangulation_nb import (
    BORDER,
    FRAME,
    FREE,
    GRID,
    TRIANGLES,
    VERTICES,
    Triangulation,
)
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

GROWTH = 2
RELAXED = 12
"""Most rounds of turning sides before the first vertex goes in."""
ANYWHERE = -1.0
"""Distance to other vertices where a vertex is put in any case."""
OWN = -1
"""Instead of a vertex of the body's mesh: a vertex of this face alone."""


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
    """Triangles of a face: first those between its polygons, then what `refined` makes of them.

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
        first, n = FRAME, len(polygons.uv)
        self.ids = np.concatenate([np.full(first, OWN), polygons.ids])
        self.t = _room(first + n + 8)
        places = (polygons.uv - self.low) / self.extent
        self.t.xy[first : first + n] = np.round(places / GRID) * GRID
        self.ears: Ints | None = None
        self.in_the_way, self.whole = self._between()

    def _between(self) -> tuple[Flags, bool]:
        """Triangles between the polygons: the segments that are in each other's way, and success.

        Sides between two copies of one vertex (at a pole, over a gap) may vanish; others may not.
        """
        t, first, n = self.t, FRAME, len(self.polygons.uv)
        border_nb.open_frame(t)
        t.used[VERTICES] = first + n
        alias = np.arange(first + n)
        at = border_nb.insert_all(t, *_order(n), self._mean_metric(), alias)
        segments = _segments(self.polygons.starts) + first
        twice, bad = np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
        border_nb.make_segments(t, at, segments, alias, twice, bad)
        a, b = segments.T
        bad &= (alias[a] != alias[b]) | (self.ids[a] != self.ids[b])
        same = bool((self.ids[alias] == self.ids).all())
        if bad.any() or not same:
            return bad, False
        inside = border_nb.flooded(t, twice, np.empty(len(t.corners), np.int64))
        border_nb.carve(t, inside)
        # Where nothing is between them, as of two chords with the same ends, all are in the way.
        whole = bool(t.used[TRIANGLES] > 0)
        return bad if whole else np.ones(n, dtype=np.bool_), whole

    def _mean_metric(self) -> FloatArray:
        """Return (3,) squares of the mean lengths of S_u and S_v over the unit square."""
        share = np.array([0.1, 0.5, 0.9])
        uv = np.stack(np.meshgrid(share, share), axis=-1).reshape(-1, 2)
        first = self.surface.derivatives(uv * self.extent + self.low, 1)
        lengths = np.linalg.norm(np.stack([first[:, 1, 0], first[:, 0, 1]], axis=1), axis=2)
        mean = lengths.mean(axis=0) * self.extent
        mean = np.maximum(mean, 1e-9 * max(float(mean.max()), 1e-300))
        return np.array([mean[0] ** 2, 0.0, mean[1] ** 2])

    def cut_ears(self) -> None:
        """Triangles between polygons that cross, none of them refined: see `ears_nb`."""
        xy = (self.polygons.uv - self.low) / self.extent
        self.ears = ears(xy, one_ring(xy, self.polygons.starts))

    def prepare(self, sag: float) -> None:
        """Points and bend at the vertices so far; sides turned to fit the bend."""
        p, q = self.surface.degrees
        frame = np.concatenate([self.low, self.extent])
        size = float(np.ptp(self.surface.evaluate(self.polygons.uv), axis=0).max())
        floor = 1.0 / max(3.0 * size * size, 1e-300)
        self.face = Face(
            self.surface.arrays, frame, sag, floor, make_scratch(p, q, 2), np.empty((3, 3, 3))
        )
        self.front = _front(self.t)
        shapes_at(self.t, self.face, self.front.points, self.front.forms)
        relax(self.t, self.front, RELAXED)
        enter_all(self.t, self.front, USELESS * sag)

    def refined(self, most: int) -> bool:
        """Put vertices in until no triangle misses by more than the distance.

        False if there would be more than `most` triangles.
        """
        heights = _heights(self.surface)
        while not refine(self.t, self.face, self.front, heights):
            if self.t.used[TRIANGLES] > most:
                return False
            self._grow()
        return True

    def put(self, x: float, y: float, apart: float) -> bool:
        """A vertex at a place of the unit square; False if it is on the border or outside."""
        if self.t.used[VERTICES] + 2 >= len(self.t.xy):
            self._grow()
        return bool(put_vertex(self.t, self.face, self.front, 0, x, y, apart))

    def renumber(self, polygons: Polygons) -> None:
        """Take other numbers for the same polygons."""
        self.polygons = polygons
        self.ids[FRAME:] = polygons.ids

    def put_inside(self, triangle: int) -> bool:
        """A vertex in the middle of a triangle; False if there is no place for one."""
        if self.ears is not None:
            return False
        x, y = self.t.xy[self.t.corners[triangle]].mean(axis=0)
        return self.put(x, y, ANYWHERE)

    def middle_of(self, triangle: int, k: int) -> tuple[float, float] | None:
        """The middle of side k of a triangle; None on the border."""
        if self.ears is not None or self.t.beside[triangle, k] == BORDER:
            return None
        a, b = self.t.corners[triangle, [(k + 1) % 3, (k + 2) % 3]]
        x, y = 0.5 * (self.t.xy[a] + self.t.xy[b])
        return float(x), float(y)

    def _grow(self) -> None:
        t = _room(GROWTH * len(self.t.xy) + 64)
        for new, old in zip(t, self.t, strict=True):
            new[: len(old)] = old
        front = _front(t)
        front.points[: len(self.t.xy)] = self.front.points
        front.forms[: len(self.t.xy)] = self.front.forms
        self.t, self.front = t, front
        enter_all(t, front, USELESS * self.face.sag)

    def triangles(self) -> Ints:
        """Return (m, 3) own vertices, the first of the polygons being 0."""
        if self.ears is not None:
            return self.ears
        return self.t.corners[: self.t.used[TRIANGLES]] - FRAME

    def own_points(self) -> FloatArray:
        """Return places (k, 3) of the face's own vertices, which follow the polygons'."""
        if self.ears is not None:
            return np.empty((0, 3))
        return self.front.points[len(self.ids) : self.t.used[VERTICES]]


def _heights(surface: NurbsSurface) -> Heights:
    middle = surface.bounds().mean(axis=0)
    coefs, u, v = extract(surface.translated(-middle))
    room = 3 * DEPTH + 4
    stack = np.empty((room, *coefs.shape[2:4], 2))
    return Heights(coefs, u, v, middle, stack, np.empty((room, 5)))


def _order(n: int) -> tuple[Ints, Ints]:
    """Vertices coarse to fine along the polygons, and for each one that is near and earlier."""
    i = np.arange(n)
    step = np.where(i == 0, np.int64(1) << 60, i & -i)
    order = np.lexsort((i, -step))
    hint = np.where(order == 0, -1, order - step[order] + FRAME)
    return order + FRAME, hint


def _segments(starts: Ints) -> Ints:
    """Return (n, 2) ends of the sides of all polygons."""
    parts = []
    for a, b in pairwise(starts):
        k = np.arange(a, b)
        parts.append(np.stack([k, np.roll(k, -1)], axis=1))
    return np.concatenate(parts)


def _room(n: int) -> Triangulation:
    m = 2 * n + 8
    return Triangulation(
        np.zeros((n, 2)),
        np.zeros((m, 3), np.int64),
        np.full((m, 3), -1, np.int64),
        np.full((m, 3), FREE, np.int64),
        np.zeros(m, np.int8),
        np.zeros(2, np.int64),
    )


def _front(t: Triangulation) -> Front:
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
