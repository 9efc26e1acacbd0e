"""Vertices along the edges of a body: as many as the tolerance needs, the same for all faces."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.border import Borders, Side, path_points
from contiga.geometry.curve_foot import CurveFeet
from contiga.geometry.faces_like import FacesLike
from contiga.geometry.kernels.shape_nb import MAX_TURN
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

SAMPLES_PER_SPAN = 12
"""Samples of each knot span for the curvature, times the degree."""
MAX_SAMPLES = 4000
MAX_HALVINGS = 30
"""Largest number of rounds that halve the sides which still miss."""
MATCH_TOL_FACTOR = 3.0
"""Images of an edge may miss it by this many of its tolerances before parameters are matched."""
MATCH_SAG_SHARE = 0.1
"""Share of the sag up to which the same holds."""
KINK_ANGLE = 1e-3
"""Smallest change of direction at a knot, radians, that is a corner of the edge."""
POLE_ANGLE = np.pi / 4
"""Largest angle at a pole between two of its places in (u, v)."""
N_MATCHES = 513
"""Samples by which the parameter of an edge is mapped to a patch's."""
SPREAD_SHARE = 0.96
"""Share of the sag for which vertices are spread: the misses never come out quite equal."""
CHORD_SHARES = np.array([0.25, 0.5, 0.75])
"""Places on a chord at which its distance from the edge is measured."""
INWARD_SHARES = (0.03, 0.1, 0.2)
"""Distances from the border at which a face's curvature counts, shares of the way to its middle."""


class EdgeShape:
    """An edge as its own curve and as the images of its sides.

    An edge of a single face is the image of its side: no other face needs the file's curve. Where
    the image of a side is off the curve at equal shares, its parameter is matched by closest
    points.

    Parameters
    ----------
    body, borders : faces, and the loops of their sides
    e : number of the edge
    sag : largest distance of its chords from it, length
    """

    def __init__(self, body: FacesLike, borders: Borders, e: int, sag: float) -> None:
        self.sides, self.sag = borders.sides[e], sag
        self.patches = [body.patches[side.path.patch] for side in self.sides]
        self.curve = borders.curves[e] if len(self.sides) > 1 else None
        self._maps: list[tuple[FloatArray, FloatArray] | None] = [None] * len(self.sides)
        """By side the parameter of the edge and of the side's path; None where they agree."""
        if self.curve is None:
            return
        match_tol = min(MATCH_TOL_FACTOR * borders.tolerances[e], MATCH_SAG_SHARE * sag)
        match_tol = max(match_tol, 1e-7 * body.size)
        for i, patch in enumerate(self.patches):
            grid = np.linspace(0.0, 1.0, 9)
            image = patch.evaluate(self.parameters(i, grid))
            if np.linalg.norm(image - self.evaluate(grid), axis=1).max() <= match_tol:
                continue
            grid = np.linspace(0.0, 1.0, N_MATCHES)
            image = patch.evaluate(self.parameters(i, grid))
            low, high = self.curve.domain
            share = (CurveFeet(self.curve)(image)[0] - low) / (high - low)
            share[0], share[-1] = 0.0, 1.0
            share = np.maximum.accumulate(np.clip(share, 0.0, 1.0))
            is_ascending = np.append(np.diff(share) > 0.0, True)
            self._maps[i] = share[is_ascending], grid[is_ascending]

    def evaluate(self, share: FloatArray) -> FloatArray:
        """Return points (n, 3) of the curve, or the only image, at shares (n,) of its range."""
        if self.curve is None:
            return self.patches[0].evaluate(self.parameters(0, share))
        low, high = self.curve.domain
        return self.curve.evaluate(np.clip(low + share * (high - low), low, high))

    def parameters(self, i: int, share: FloatArray) -> FloatArray:
        """Return (n, 2) parameters of the patch of side i at shares of the edge's range."""
        parameter_map = self._maps[i]
        shares = share if parameter_map is None else np.interp(share, *parameter_map)
        if self.sides[i].reversed:
            shares = 1.0 - shares
        return path_points(self.sides[i].path, self.patches[i], shares)

    def misses(self, share: FloatArray, sag: float) -> NDArray[np.bool_]:
        """Return (n − 1,) which chords are more than `sag` off the edge, or off a patch beside it.

        Chords join the points at ascending shares (n,). One between the images of two vertices is
        compared with their patch along the straight line in (u, v). Both tests are at
        `CHORD_SHARES` of the chord. Flat patches are left out.
        """
        between = share[:-1, None] + np.diff(share)[:, None] * CHORD_SHARES
        bad = _chord_distance(self.evaluate(share), self.evaluate(between.ravel())) > sag
        for i, patch in enumerate(self.patches):
            if not _is_flat(patch):
                uv = self.parameters(i, share)
                uv_between = uv[:-1, None] + np.diff(uv, axis=0)[:, None] * CHORD_SHARES[:, None]
                points = patch.evaluate(uv_between.reshape(-1, 2))
                bad |= _chord_distance(patch.evaluate(uv), points) > sag
        return bad

    def inner_curvature(self, share: FloatArray) -> FloatArray:
        """Return (n,) largest normal curvature, 1/length, of the face just inside an open border.

        If the border is straight and the face next to it is curved, one long side would get many
        triangles as thin as needles. It is zero for an edge with a `curve` of its own, which
        decides, and beside a flat patch.
        """
        curvature = np.zeros(len(share))
        if self.curve is not None or len(share) < 2 or _is_flat(self.patches[0]):
            return curvature
        patch = self.patches[0]
        uv = self.parameters(0, share)
        tangent = np.gradient(uv, axis=0)
        middle = np.array(patch.domain).mean(axis=1)
        for inward in INWARD_SHARES:
            inner_uv = uv + inward * (middle - uv)
            curvature = np.maximum(curvature, _normal_curvature(patch, inner_uv, tangent))
        return curvature


def _normal_curvature(patch: NurbsSurface, uv: FloatArray, direction: FloatArray) -> FloatArray:
    """Return (n,) absolute normal curvature, 1/length, at parameters (n, 2) in directions (n, 2).

    Where the surface has no normal or the direction no length it is about zero.
    """
    d = patch.derivatives(uv, 2)
    x, y = direction.T[:, :, None]
    normal = np.cross(d[:, 1, 0], d[:, 0, 1])
    normal /= np.maximum(np.sqrt((normal * normal).sum(axis=1)), 1e-300)[:, None]
    slope = x * d[:, 1, 0] + y * d[:, 0, 1]
    second = x * x * d[:, 2, 0] + 2.0 * x * y * d[:, 1, 1] + y * y * d[:, 0, 2]
    square = np.maximum((slope * slope).sum(axis=1), 1e-300)
    return np.asarray(np.abs((second * normal).sum(axis=1)) / square)


def _chord_distance(vertices: FloatArray, points: FloatArray) -> FloatArray:
    """Return (n − 1,) largest distance from each chord of the points that belong to it."""
    start, step = vertices[:-1, None], np.diff(vertices, axis=0)[:, None]
    offset = points.reshape(len(vertices) - 1, -1, 3) - start
    square = np.maximum((step * step).sum(axis=-1), 1e-300)
    t = np.clip((offset * step).sum(axis=-1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - t[..., None] * step, axis=-1).max(axis=1))


def _is_flat(patch: NurbsSurface) -> bool:
    """Return whether a patch is a bilinear B-spline that is an affine image of its rectangle."""
    if patch.degrees != (1, 1) or patch.control_points.shape[:2] != (2, 2) or patch.is_rational:
        return False
    (a, b), (c, d) = patch.control_points
    return bool(np.abs(a - b - c + d).max() <= 1e-12 * np.abs(d - a).max())


def chain_shares(edge: EdgeShape, sag: float, closed: bool) -> FloatArray:
    """Return ascending shares, 0 and 1 included, of the vertices along an edge.

    They are spread between corners of its curve so that all chords miss by about as much (density
    √(bend / 8 sag)), then the chords that miss by more than `sag` are halved, up to `MAX_HALVINGS`
    times. A `closed` edge gets three chords at least.
    """
    kinks = [0.0, 1.0]
    curve = edge.curve
    if curve is not None:
        low, high = curve.domain
        knots, times = np.unique(curve.knots, return_counts=True)
        for t in knots[(times >= curve.degree) & (knots > low) & (knots < high)]:
            step = 1e-7 * (high - low)
            d = curve.derivatives([t - step, t + step], 1)[:, 1]
            d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-300)
            if np.linalg.norm(d[1] - d[0]) > KINK_ANGLE:
                kinks.append((t - low) / (high - low))
    parts = [_spread(edge, a, b, SPREAD_SHARE * sag) for a, b in pairwise(np.sort(kinks))]
    share = np.append(np.concatenate([part[:-1] for part in parts]), 1.0)
    min_chords = 3 if closed else 1
    if len(share) <= min_chords:
        share = np.linspace(0.0, 1.0, min_chords + 1)
    for _ in range(MAX_HALVINGS):
        bad = edge.misses(share, sag)
        if not bad.any():
            break
        share = np.sort(np.concatenate([share, 0.5 * (share[:-1] + share[1:])[bad]]))
    return share


def _spread(edge: EdgeShape, a: float, b: float, sag: float) -> FloatArray:
    """Return ascending shares, a to b, so that chords miss by about `sag`; a and b for a line.

    A chord also turns by about a quarter of a turn at most.
    """
    curve = edge.curve
    if curve is not None and curve.degree == 1 and len(curve.knots) == 4:
        return np.array([a, b])
    spans = 8 if curve is None else (len(np.unique(curve.knots)) - 1) * curve.degree
    grid = np.linspace(a, b, min(SAMPLES_PER_SPAN * spans, MAX_SAMPLES) + 1)
    points = edge.evaluate(grid)
    slope = 0.5 * (points[2:] - points[:-2])
    second = points[2:] - 2.0 * points[1:-1] + points[:-2]
    speed = np.maximum((slope * slope).sum(axis=1), 1e-300)
    tangential = (second * slope).sum(axis=1) / speed
    bend = np.linalg.norm(second - tangential[:, None] * slope, axis=1)
    # Within a step: √(bend / 8 sag) chords, and at most about a quarter of a turn a chord.
    density = np.sqrt(np.maximum(bend / (8.0 * sag), bend * bend / speed / (8.0 * MAX_TURN)))
    inner_density = np.sqrt(speed * edge.inner_curvature(grid[1:-1]) / (8.0 * sag))
    density = np.maximum(density, inner_density)
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
    """Return equal shares, 0 to 1, along a side that is a pole.

    There is a part for each `POLE_ANGLE` between the lines that leave the pole inward.
    """
    share = np.linspace(0.0, 1.0, 33)
    uv = path_points(side.path, patch, share)
    middle = np.array(patch.domain).mean(axis=1)
    direction = patch.evaluate(uv + 1e-4 * (middle - uv)) - patch.evaluate(uv)
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-300)
    angle = np.linalg.norm(np.diff(direction, axis=0), axis=1).sum()
    return np.linspace(0.0, 1.0, max(1, int(np.ceil(angle / POLE_ANGLE - 1e-3))) + 1)
