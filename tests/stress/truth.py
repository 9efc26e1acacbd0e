"""On which side of a solid a point lies, and places on its surface: judged without the search."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from tests.cases import occ
from tests.stress.fields import Field, norm
from tests.stress.solids import Solid

import contiga as cg

# Points closer to the surface than this, relative to the size, are not judged: it is a little
# more than OpenCASCADE's own tolerance of 1e-7 on bodies of fifty.
BAND = 2e-9


def values(solid: Solid, p: np.ndarray) -> np.ndarray:
    """(n,) the closed form, or the gaps of contiga's closest points where there is none."""
    return solid.field(p) if solid.field is not None else solid.body.project(p).gap


def signs(solid: Solid, p: np.ndarray, band: float = BAND) -> np.ndarray:
    """(n,) +1 outside, −1 inside, 0 within `band` sizes of the surface.

    Of CAD files, by contiga's closest points: what disagrees with them goes to `settled`.
    """
    value = values(solid, p)
    return np.where(np.abs(value) <= band * solid.size, 0, np.sign(value)).astype(int)


def settled(solid: Solid, p: np.ndarray, sign: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """`sign` with `rows` of it looked at closely: joints, and OpenCASCADE where it has to say."""
    sign = sign.copy()
    sign[rows[at_a_joint(solid, p[rows])]] = 0
    if solid.field is None and len(rows):
        known = rows[sign[rows] != 0]
        sign[known] = np.where(occ.inside(solid.shape, p[known]), -1, 1)
    return sign


class Walked(NamedTuple):
    """What the paths of n segments meet; shares of the way, NaN where there is none."""

    outside: np.ndarray
    """(n,) bool: some place of the path was certainly outside."""
    leaves_free: np.ndarray
    """(n,) share of the last place outside before the first entry found."""
    entered: np.ndarray
    """(n,) share of a place just inside, to rounding behind `leaves_free`."""


def walk(field: Field, a: np.ndarray, b: np.ndarray, band: float, finest: int = 256) -> Walked:
    """Follow segments through a field, never past a surface unless in steps of 1 / `finest`.

    A field's size is a lower bound of the distance: so far nothing can be met. Only what a path
    crosses twice within a step of 1 / `finest` of it can be overlooked.
    """
    way = norm(b - a)
    t, value = np.zeros(len(a)), field(a)
    outside = value > band
    low, high = np.where(outside, 0.0, np.nan), np.full(len(a), np.nan)
    rows = np.flatnonzero(way > 0.0)
    while len(rows):
        step = np.maximum(np.abs(value[rows]) / way[rows], 1.0 / finest)
        t[rows] = np.minimum(t[rows] + step, 1.0)
        value[rows] = now = field(a[rows] + t[rows, None] * (b - a)[rows])
        out = now > band
        outside[rows[out]] = True
        low[rows[out]] = t[rows[out]]
        entered = (now < -band) & ~np.isnan(low[rows])
        high[rows[entered]] = t[rows[entered]]
        rows = rows[~entered & (t[rows] < 1.0)]
    rows = np.flatnonzero(~np.isnan(high))
    for _ in range(52):
        middle = 0.5 * (low[rows] + high[rows])
        out = field(a[rows] + middle[:, None] * (b - a)[rows]) > 0.0
        low[rows] = np.where(out, middle, low[rows])
        high[rows] = np.where(out, high[rows], middle)
    low[np.isnan(high)] = np.nan
    return Walked(outside, low, high)


def may_leave(solid: Solid, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n,) whether segments that begin and end inside may have been outside on their way."""
    # A point must come out as deep as it was, and go in as deep as it will be.
    result = -values(solid, a) - values(solid, b) <= norm(b - a)
    rows = np.flatnonzero(result)
    if len(rows) and solid.field is not None:
        result[rows] = ~stays_inside(solid.field, a[rows], b[rows], BAND * solid.size)
    return result


def stays_inside(
    field: Field, a: np.ndarray, b: np.ndarray, band: float, parts: int = 256
) -> np.ndarray:
    """(n,) whether segments are proved to stay inside by `band` all the way.

    Between two places of a path the field is nowhere more than half of both values and of the way
    between them. Parts that may come out are halved; where more than `parts` stay open, nothing is
    proved.
    """
    way = norm(b - a)
    of = np.arange(len(a))
    low, high = np.zeros(len(a)), np.ones(len(a))
    at_low, at_high = field(a), field(b)
    stays = np.ones(len(a), bool)
    while len(of):
        stays[of[np.maximum(at_low, at_high) > -band]] = False
        unsure = 0.5 * (at_low + at_high + way[of] * (high - low)) > -band
        stays[np.bincount(of[unsure], minlength=len(a)) > parts] = False
        keep = unsure & stays[of]
        of, low, high = of[keep], low[keep], high[keep]
        at_low, at_high = at_low[keep], at_high[keep]
        middle = 0.5 * (low + high)
        value = field(a[of] + middle[:, None] * (b - a)[of])
        of = np.concatenate([of, of])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        at_low, at_high = np.concatenate([at_low, value]), np.concatenate([value, at_high])
    return stays


def gradient(field: Field, p: np.ndarray, h: float) -> np.ndarray:
    """(n, 3) central differences of a field, made unit vectors."""
    step = h * np.eye(3)
    g = np.stack([field(p + e) - field(p - e) for e in step], axis=1)
    return g / np.maximum(norm(g), 1e-300)[:, None]


def on_surface(solid: Solid, n: int, rng: np.random.Generator) -> np.ndarray:
    """About n points on the surface, from all over the box around it."""
    low, high = solid.body.bounds()
    p = low + (high - low) * rng.uniform(-0.05, 1.05, (n, 3))
    if solid.field is None:
        return solid.body.project(p).point
    for _ in range(20):
        p = p - solid.field(p)[:, None] * gradient(solid.field, p, 1e-7 * solid.size)
    return p[np.abs(solid.field(p)) <= 1e-10 * solid.size]


def on_edges(solid: Solid, n: int, rng: np.random.Generator, *, ends: bool = False) -> np.ndarray:
    """n points on the edges, or at their ends."""
    edges = solid.body.edges
    of = rng.integers(len(edges), size=n)
    p = np.empty((n, 3))
    for k in np.unique(of):
        rows = np.flatnonzero(of == k)
        a, b = edges[k].curve.domain
        share = rng.integers(0, 2, len(rows)) if ends else rng.random(len(rows))
        p[rows] = edges[k].curve.evaluate(a + (b - a) * share)
    return p


def on_knots(solid: Solid, n: int, rng: np.random.Generator, *, poles: bool = False) -> np.ndarray:
    """Up to n points of the surface on knot lines of its patches, or at their corners."""
    patches = solid.body.patches
    of = rng.integers(len(patches), size=n)
    found = []
    for k in np.unique(of):
        count = int((of == k).sum())
        (u0, u1), (v0, v1) = patches[k].domain
        uv = np.array([u0, v0]) + np.array([u1 - u0, v1 - v0]) * rng.random((count, 2))
        marks = [np.unique(knots) for knots in patches[k].knots]
        for side in range(2):
            inner = marks[side][(marks[side] >= (u0, v0)[side]) & (marks[side] <= (u1, v1)[side])]
            rows = np.flatnonzero(rng.random(count) < (1.0 if poles else 0.6))
            uv[rows, side] = inner[rng.integers(len(inner), size=len(rows))]
        found.append(patches[k].evaluate(uv))
    p = np.concatenate(found)
    if solid.field is None:
        return p[np.abs(solid.body.project(p).gap) <= 1e-9 * solid.size]
    return p[np.abs(solid.field(p)) <= BAND * solid.size]


def at_a_joint(
    solid: Solid, p: np.ndarray, factor: float | np.ndarray = 2.0, samples: int = 400
) -> np.ndarray:
    """(n,) whether points lie within `factor` (one or n) times the stated tolerance of an edge."""
    near = np.zeros(len(p), bool)
    factor = np.broadcast_to(factor, len(p))
    if len(p) == 0:
        return near
    close = np.ones(len(p), bool)
    if solid.field is not None:
        widest = max(edge.tolerance for edge in solid.body.edges)
        close = np.abs(solid.field(p)) <= factor * widest
    for edge in solid.body.edges:
        low, high = edge.curve.bounds()
        far = np.maximum(low - p, p - high).max(axis=1) > factor * edge.tolerance
        rows = np.flatnonzero(close & ~near & ~far)
        for part in np.array_split(rows, len(rows) // 5000 + 1):
            within = factor[part] * edge.tolerance
            near[part] = _distance_to(edge.curve, p[part], samples, within) <= within
    return near


def _distance_to(
    curve: cg.NurbsCurve, p: np.ndarray, samples: int, within: np.ndarray
) -> np.ndarray:
    """Distance to a curve: samples, zoomed in on where it may be `within` (n,)."""
    a, b = curve.domain
    t = np.linspace(a, b, samples)
    places = curve.evaluate(t)
    d = np.linalg.norm(p[:, None] - places[None], axis=2)
    least = np.asarray(d.min(axis=1))
    # No place of the curve is farther from a sample than samples are apart.
    apart = norm(np.diff(places, axis=0)).max()
    rows = np.flatnonzero(least <= within + 2.0 * apart)
    if len(rows) == 0:
        return least
    at, width = t[d[rows].argmin(axis=1)], (b - a) / (samples - 1)
    for _ in range(36):
        tried = np.clip(at[:, None] + width * np.linspace(-1.0, 1.0, 5), a, b)
        values = curve.evaluate(tried.ravel()).reshape(len(rows), 5, 3)
        d = np.linalg.norm(p[rows, None] - values, axis=2)
        at = np.take_along_axis(tried, d.argmin(axis=1)[:, None], axis=1)[:, 0]
        width *= 0.6
    least[rows] = d.min(axis=1)
    return least
