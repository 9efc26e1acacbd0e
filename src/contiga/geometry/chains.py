"""Vertices along the edges of a body: as many as the distance asks for, the same for all faces."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.border import Borders, Side, path_points
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.curve_foot import CurveFeet
from contiga.geometry.faces_like import FacesLike
from contiga.geometry.kernels.shape_nb import TURN
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

PER_SPAN = 12
"""Samples of each knot span from which the bend is taken, times the degree."""
MAX_SAMPLES = 4000
ROUNDS = 30
"""Halvings of sides that still miss."""
LOOSE = 3.0
"""Images of an edge may be off by this many of its tolerances before parameters are matched."""
ASTRAY = 0.1
"""Or by this share of the distance that is asked for."""
KINK = 1e-3
"""Change of direction at a knot, radians, that is a corner of the edge."""
POLE_ANGLE = np.pi / 4
"""Largest angle at a pole between two of its places in (u, v)."""
MATCHED = 513
"""Places from which the parameter of an edge is carried over to a patch's."""
EVEN = 0.96
"""Share of the distance for which vertices are spread, which never come out quite even."""
WITHIN = np.array([0.25, 0.5, 0.75])
INSIDE = (0.03, 0.1, 0.2)
"""How far inside a face, as a share of the way to its middle, its bend counts for its border."""


class EdgeShape:
    """An edge as its own curve and as the images of its sides.

    An edge of one face alone is the image of its side: no other face asks for the file's curve.

    Parameters
    ----------
    body, borders : faces, and the loops of their sides
    e : number of the edge
    sag : how far its chords may miss, length
    """

    def __init__(self, body: FacesLike, borders: Borders, e: int, sag: float) -> None:
        self.sides, self.sag = borders.sides[e], sag
        self.patches = [body.patches[side.path.patch] for side in self.sides]
        self.curve = borders.curves[e] if len(self.sides) > 1 else None
        loose = min(LOOSE * borders.tolerances[e], ASTRAY * sag)
        self.loose = max(loose, 1e-7 * body.size)
        self._match: list[tuple[FloatArray, FloatArray] | None] = [None] * len(self.sides)
        for i in range(len(self.sides)):
            self._match[i] = self._matched(i)

    def evaluate(self, share: FloatArray) -> FloatArray:
        """Points (n, 3) at shares of the edge's range."""
        if self.curve is None:
            return self.patches[0].evaluate(self.parameters(0, share))
        low, high = self.curve.domain
        return self.curve.evaluate(np.clip(low + share * (high - low), low, high))

    def parameters(self, i: int, share: FloatArray) -> FloatArray:
        """Return (n, 2) parameters of the patch of side i at shares of the edge's range."""
        match = self._match[i]
        shares = share if match is None else np.interp(share, *match)
        if self.sides[i].reversed:
            shares = 1.0 - shares
        return path_points(self.sides[i].path, self.patches[i], shares)

    def _matched(self, i: int) -> tuple[FloatArray, FloatArray] | None:
        """Return the parameter of a side by that of the edge; None where they agree."""
        if self.curve is None:
            return None
        grid = np.linspace(0.0, 1.0, 9)
        image = self.patches[i].evaluate(self.parameters(i, grid))
        if np.linalg.norm(image - self.evaluate(grid), axis=1).max() <= self.loose:
            return None
        grid = np.linspace(0.0, 1.0, MATCHED)
        image = self.patches[i].evaluate(self.parameters(i, grid))
        low, high = self.curve.domain
        share = (CurveFeet(self.curve)(image)[0] - low) / (high - low)
        share[0], share[-1] = 0.0, 1.0
        share = np.maximum.accumulate(np.clip(share, 0.0, 1.0))
        keep = np.append(np.diff(share) > 0.0, True)
        return share[keep], grid[keep]

    def missed(self, share: FloatArray, sag: float) -> NDArray[np.bool_]:
        """Return which sides (n − 1,) between neighbours are off the edge or its image."""
        between = share[:-1, None] + np.diff(share)[:, None] * WITHIN
        bad = _off(self.evaluate(share), self.evaluate(between.ravel())) > sag
        for i, patch in enumerate(self.patches):
            if not _is_flat(patch):
                uv = self.parameters(i, share)
                across = uv[:-1, None] + np.diff(uv, axis=0)[:, None] * WITHIN[:, None]
                off = _off(patch.evaluate(uv), patch.evaluate(across.reshape(-1, 2)))
                bad |= off > sag
        return bad

    def bend_inside(self, share: FloatArray) -> FloatArray:
        """Return (n,) largest curvature (1/length) along an open border of the face inside it.

        A border that is straight while the face beside it is not would be one side for many
        triangles: thin as needles. Zero for edges of several faces, whose bend is the edge's.
        """
        bend = np.zeros(len(share))
        if self.curve is not None or len(share) < 2 or _is_flat(self.patches[0]):
            return bend
        patch = self.patches[0]
        uv = self.parameters(0, share)
        along = np.gradient(uv, axis=0)
        middle = np.array(patch.domain).mean(axis=1)
        for part in INSIDE:
            bend = np.maximum(bend, _bend_along(patch, uv + part * (middle - uv), along))
        return bend


def _bend_along(patch: NurbsSurface, uv: FloatArray, along: FloatArray) -> FloatArray:
    """Return (n,) normal curvature, without its sign, at (n, 2) parameters in directions (n, 2)."""
    d = patch.derivatives(uv, 2)
    x, y = along.T[:, :, None]
    normal = np.cross(d[:, 1, 0], d[:, 0, 1])
    normal /= np.maximum(np.sqrt((normal * normal).sum(axis=1)), 1e-300)[:, None]
    slope = x * d[:, 1, 0] + y * d[:, 0, 1]
    second = x * x * d[:, 2, 0] + 2.0 * x * y * d[:, 1, 1] + y * y * d[:, 0, 2]
    square = np.maximum((slope * slope).sum(axis=1), 1e-300)
    return np.asarray(np.abs((second * normal).sum(axis=1)) / square)


def _off(ends: FloatArray, between: FloatArray) -> FloatArray:
    """Return (n − 1,) largest distance of the places between from the side they belong to."""
    a, step = ends[:-1, None], np.diff(ends, axis=0)[:, None]
    away = between.reshape(len(ends) - 1, -1, 3) - a
    square = np.maximum((step * step).sum(axis=-1), 1e-300)
    t = np.clip((away * step).sum(axis=-1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - t[..., None] * step, axis=-1).max(axis=1))


def _is_flat(patch: NurbsSurface) -> bool:
    """Return whether a patch is an affine image of its rectangle."""
    if patch.degrees != (1, 1) or patch.control_points.shape[:2] != (2, 2) or patch.is_rational:
        return False
    (a, b), (c, d) = patch.control_points
    return bool(np.abs(a - b - c + d).max() <= 1e-12 * np.abs(d - a).max())


def chain_shares(edge: EdgeShape, sag: float, closed: bool) -> FloatArray:
    """Shares of the vertices along an edge so that no side misses by more than `sag`.

    They are spread so that all sides miss by about as much (density √(bend / 8 sag)), then those
    that miss are halved.
    """
    corners = _kinks(edge.curve)
    parts = [_spread(edge, a, b, EVEN * sag) for a, b in pairwise(corners)]
    share = np.append(np.concatenate([part[:-1] for part in parts]), 1.0)
    least = 3 if closed else 1
    if len(share) <= least:
        share = np.linspace(0.0, 1.0, least + 1)
    for _ in range(ROUNDS):
        bad = edge.missed(share, sag)
        if not bad.any():
            break
        share = np.sort(np.concatenate([share, 0.5 * (share[:-1] + share[1:])[bad]]))
    return share


def _kinks(curve: NurbsCurve | None) -> FloatArray:
    """Shares 0, 1 and those at which the direction of the curve jumps."""
    kinks = [0.0, 1.0]
    if curve is not None:
        low, high = curve.domain
        knots, times = np.unique(curve.knots, return_counts=True)
        for t in knots[(times >= curve.degree) & (knots > low) & (knots < high)]:
            step = 1e-7 * (high - low)
            d = curve.derivatives([t - step, t + step], 1)[:, 1]
            d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-300)
            if np.linalg.norm(d[1] - d[0]) > KINK:
                kinks.append((t - low) / (high - low))
    return np.sort(kinks)


def _spread(edge: EdgeShape, a: float, b: float, sag: float) -> FloatArray:
    """Shares from a to b, dense where the edge is bent."""
    curve = edge.curve
    if curve is not None and curve.degree == 1 and len(curve.knots) == 4:
        return np.array([a, b])
    spans = 8 if curve is None else (len(np.unique(curve.knots)) - 1) * curve.degree
    grid = np.linspace(a, b, min(PER_SPAN * spans, MAX_SAMPLES) + 1)
    points = edge.evaluate(grid)
    slope = 0.5 * (points[2:] - points[:-2])
    second = points[2:] - 2.0 * points[1:-1] + points[:-2]
    speed = np.maximum((slope * slope).sum(axis=1), 1e-300)
    along = (second * slope).sum(axis=1) / speed
    bend = np.linalg.norm(second - along[:, None] * slope, axis=1)
    # Within a step: √(bend / 8 sag) sides, and no more than about a quarter of a turn a side.
    density = np.sqrt(np.maximum(bend / (8.0 * sag), bend * bend / speed / (8.0 * TURN)))
    beside = np.sqrt(speed * edge.bend_inside(grid[1:-1]) / (8.0 * sag))
    density = np.maximum(density, beside)
    density = np.concatenate([density[:1], density, density[-1:]])
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[:-1] + density[1:]))])
    n = max(1, int(np.ceil(total[-1] * (1.0 - 1e-9))))
    if n == 1:
        return np.array([a, b])
    total = total + 1e-9 * total[-1] * np.linspace(0.0, 1.0, len(total))
    share = np.interp(np.linspace(0.0, total[-1], n + 1), total, grid)
    share[0], share[-1] = a, b
    return share


def pole_shares(side: Side, patch: NurbsSurface) -> FloatArray:
    """Shares along a side that is one point, by the angle between the lines that leave it."""
    share = np.linspace(0.0, 1.0, 33)
    uv = path_points(side.path, patch, share)
    middle = np.array(patch.domain).mean(axis=1)
    away = patch.evaluate(uv + 1e-4 * (middle - uv)) - patch.evaluate(uv)
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-300)
    turned = np.linalg.norm(np.diff(away, axis=0), axis=1).sum()
    return np.linspace(0.0, 1.0, max(1, int(np.ceil(turned / POLE_ANGLE - 1e-3))) + 1)
