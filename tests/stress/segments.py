"""Segments against closed bodies: first entries, none missed, none false, none too late.

A segment from outside to inside must hit. A hit lies on the segment and on the surface and enters
it; there is no entry before it. Judged by the closed forms, followed along each segment in steps
no longer than the surface is off.
"""

from __future__ import annotations

import numpy as np
from tests.stress import truth
from tests.stress.fields import norm
from tests.stress.solids import Solid
from tests.stress.tally import Clock, Tally

import contiga as cg
from contiga.records import Hit

ROUNDING = 8.0 * float(np.finfo(float).eps)
"""Heights below it, relative to the coordinates and the size, are none."""
FINE = 1e-12
"""Ends closer to the surface than this, relative to the size, are not judged, away from edges."""
SHORTEST, LONGEST = 1e-9, 3.0
AIMS = ("random", "face", "edge", "vertex", "knot", "pole")


def places(solid: Solid, aim: str, n: int, rng: np.random.Generator) -> np.ndarray:
    """Points of the surface to aim at."""
    if aim == "edge":
        return truth.on_edges(solid, n, rng)
    if aim == "vertex":
        return truth.on_edges(solid, n, rng, ends=True)
    if aim in ("knot", "pole"):
        return truth.on_knots(solid, n, rng, poles=aim == "pole")
    return truth.on_surface(solid, n, rng)


def normals(solid: Solid, q: np.ndarray) -> np.ndarray:
    """Unit vectors across the surface at points of it; between those of the faces at edges."""
    if solid.field is not None:
        return truth.gradient(solid.field, q, 1e-6 * solid.size)
    return solid.body.project(q).normal


def segments(
    solid: Solid, aim: str, n: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """About n segments: lengths log-uniform, angles to the surface grazing to straight in."""
    q = places(solid, aim, n, rng)
    n = len(q)
    d = rng.normal(size=(n, 3))
    d /= norm(d)[:, None]
    if aim != "random":
        normal = normals(solid, q)
        along = d - (d * normal).sum(axis=1)[:, None] * normal
        along /= np.maximum(norm(along), 1e-300)[:, None]
        slope = 10.0 ** rng.uniform(-6.0, 0.0, (n, 1))
        d = np.sqrt(1.0 - slope**2) * along - slope * normal
    length = solid.size * np.exp(rng.uniform(np.log(SHORTEST), np.log(LONGEST), (n, 1)))
    share = rng.random((n, 1))
    if aim == "random":
        q = q + rng.normal(size=q.shape) * length
    return q - share * length * d, q + (1.0 - share) * length * d


def check(solid: Solid, a: np.ndarray, b: np.ndarray, hit: Hit, tally: Tally) -> None:
    """Judge the first entries of the segments a → b."""
    size, band = solid.size, FINE * solid.size
    values = {"a": a, "b": b, "fraction": hit.fraction, "status": hit.status}
    found = hit.patch >= 0
    flagged = ~np.isin(hit.status, (cg.Status.OK, cg.Status.AT_START, cg.Status.NO_HIT))
    tally.count += len(a)
    tally.flagged += int(flagged.sum())
    _check_found(solid, a, b, hit, np.flatnonzero(found & ~flagged), tally, values)
    if solid.field is None:
        _check_ends(solid, a, b, found | flagged, tally, values)
        return
    walked = truth.walk(solid.field, a, b, band)
    enters = ~np.isnan(walked.entered)
    missed = _clear_of_edges(solid, a, b, enters & ~found & ~flagged, tally)
    tally.fault("missed", missed, **values)
    # An entry before the hit counts if the path between them is inside by more than rounding.
    early = np.flatnonzero(enters & found & ~flagged & (hit.fraction > walked.entered))
    share = 0.5 * (walked.entered[early] + hit.fraction[early])
    deep = solid.field(a[early] + share[:, None] * (b - a)[early]) < -truth.BAND * size
    tally.fault("not the first", early[deep], **values)


def _clear_of_edges(
    solid: Solid, a: np.ndarray, b: np.ndarray, missed: np.ndarray, tally: Tally
) -> np.ndarray:
    """Rows missed, without those that get no deeper than the tolerance of an edge they pass."""
    rows = np.flatnonzero(missed)
    if len(rows) == 0:
        return rows
    assert solid.field is not None
    # The deepest place of the path decides: a joint is as wide as the file says.
    deepest, least = a[rows].copy(), np.full(len(rows), np.inf)
    for share in np.linspace(0.0, 1.0, 65):
        p = a[rows] + share * (b - a)[rows]
        value = solid.field(p)
        deepest[value < least] = p[value < least]
        least = np.minimum(least, value)
    excused = truth.at_a_joint(solid, deepest)
    tally.doubtful += int(excused.sum())
    return rows[~excused]


def _check_found(
    solid: Solid,
    a: np.ndarray,
    b: np.ndarray,
    hit: Hit,
    rows: np.ndarray,
    tally: Tally,
    values: dict[str, np.ndarray],
) -> None:
    """Each hit is on the segment and on the surface, and enters."""
    size, d = solid.size, b - a
    way = norm(d)
    off = norm(a[rows] + hit.fraction[rows, None] * d[rows] - hit.point[rows])
    within = (hit.fraction[rows] >= 0.0) & (hit.fraction[rows] <= 1.0)
    far = ~within | ~(off <= 1e-9 * size)
    normal = np.empty((len(rows), 3))
    on_patch = np.empty((len(rows), 3))
    for k in np.unique(hit.patch[rows]):
        own = np.flatnonzero(hit.patch[rows] == k)
        normal[own] = solid.body.patches[k].normal(hit.uv[rows[own]])
        on_patch[own] = solid.body.patches[k].evaluate(hit.uv[rows[own]])
    slope = (normal * d[rows]).sum(axis=1) / way[rows]
    # What a joint is wide as seen along the path, it is wider on the surface.
    wide = 4.0 / np.maximum(np.abs(slope), 0.02)
    far[far] = ~_excused(solid, a, d, hit, rows[far], off[far], wide[far])
    tally.fault("off the segment", rows[far], point=hit.point, **values)
    stray = norm(on_patch - hit.point[rows]) > 1e-9 * size
    if solid.field is not None:
        off_field = ~(np.abs(solid.field(hit.point[rows])) <= truth.BAND * size)
        at = hit.point[rows[off_field]]
        off_field[off_field] = ~truth.at_a_joint(solid, at, wide[off_field])
        stray |= off_field
    tally.fault("off the surface", rows[stray], point=hit.point, **values)
    leaves = rows[slope > 1e-9]
    # At a vertex the normal of a face need not tell: what lies before and behind it does.
    small = np.minimum(1e-8 * size / way[leaves], 1.0)[:, None] * d[leaves]
    ahead, behind = (truth.values(solid, hit.point[leaves] + k * small) for k in (1.0, -1.0))
    # A path that only touches is in and out again within rounding: there its slope has no sign.
    # Nor has it at the tip of a hollow cone that a path passes from inside to inside.
    rounding = ROUNDING * (np.abs(hit.point[leaves]).max(axis=1, initial=0.0) + size)
    leaves = leaves[(ahead - behind >= rounding) & (ahead >= -rounding)]
    leaves = leaves[~truth.at_a_joint(solid, hit.point[leaves], factor=4.0)]
    tally.fault("does not enter", leaves, point=hit.point, **values)


def _excused(
    solid: Solid,
    a: np.ndarray,
    d: np.ndarray,
    hit: Hit,
    rows: np.ndarray,
    off: np.ndarray,
    wide: np.ndarray,
) -> np.ndarray:
    """(n,) hits that may stand `off` their place on the segment.

    Within its width an edge belongs to both faces that meet there. A path that runs along the
    surface within rounding has no sharper place than the root of that.
    """
    widest = max(edge.tolerance for edge in solid.body.edges)
    joint = (off <= wide * widest) & truth.at_a_joint(solid, hit.point[rows], wide)
    place = a[rows] + hit.fraction[rows, None] * d[rows]
    along = np.abs(truth.values(solid, place)) <= 1e-11 * solid.size
    return joint | (along & (off <= 5e-8 * solid.size))


def _check_ends(
    solid: Solid,
    a: np.ndarray,
    b: np.ndarray,
    settled: np.ndarray,
    tally: Tally,
    values: dict[str, np.ndarray],
) -> None:
    """Without a closed form: what begins outside and ends inside hits."""
    rows = np.flatnonzero(~settled)
    from_out = rows[truth.signs(solid, a[rows]) > 0]
    rows = from_out[truth.signs(solid, b[from_out]) < 0]
    start, end = (truth.settled(solid, p[rows], np.ones(len(rows), int), np.arange(len(rows)))
                  for p in (a, b))  # fmt: skip
    tally.fault("missed", rows[(start > 0) & (end < 0)], **values)


def shot(solid: Solid, n: int, seed: int) -> Tally:
    """About n segments of all aims at one body."""
    tally = Tally(f"segments, {solid.name}")
    for k, aim in enumerate(AIMS):
        rng = np.random.default_rng([seed, k])
        left = n // len(AIMS)
        while left > 0:
            with Clock(tally):
                a, b = segments(solid, aim, min(left, 20_000), rng)
                check(solid, a, b, solid.body.first_hit(a, b), tally)
            left -= 20_000
    return tally
