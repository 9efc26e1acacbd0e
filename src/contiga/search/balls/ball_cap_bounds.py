"""Caps: blocks all around a pole for which the radius of touching balls has a proved bound.

Let elements close around a pole P where their tangents are in one plane, n its normal. With τ the
parameter from the pole and x that along its side, S − P = τ C(x, τ), and C = B/w is rational too.
Its part in the plane is τ c, its height τ² G, since n·C(x, 0) = 0.

**The cap is a graph.** Where det(c, c_x) > 0 the directions seen from P turn one way along x, and
where det(U, V) of V = c + τ c_τ and U = c_x has that sign, the map (x, τ) ↦ τ c preserves the
orientation of the plane. If c goes around once at τ = 0, it does at every τ: the lines τ = T are
closed curves about P that meet each ray once. A map that preserves orientation takes each value as
often as the image of the border goes around it: once inside, never outside. So the cap is the graph
of a function f over a region D of the plane, and D contains the disk up to the least distance of
its border.

**It is C¹.** From ∇f·U = τ G_x and ∇f·V = 2 τ G + τ² G_τ follows ∇f = τ m, m bounded: the
tangent plane at P is that of all the tangents there, and ∇f is Lipschitz about P. Across the joints
of the elements it is continuous if they share their curves and tangent planes: polynomials in τ
vanish if they do at as many places as they have coefficients.

**Its curvature.** Differentiated once more the two equations give the second derivatives H of f in
the frame (U, V), in which nothing vanishes at the pole:

    H(U, U) = G_xx − m·c_xx
    H(U, V) = G_x + τ (G_xτ − m·c_xτ)
    H(V, V) = 2 G + 4 τ G_τ + τ² G_ττ − τ m·(2 c_τ + τ c_ττ).

**The balls.** Let X and Q be points over a disk in D, d the vector between them in the plane, N the
normal at Q to the side in question. The straight line is in the disk, so

    N·(X − Q) = (N·n) ∫ (1 − s) H(d, d) ds ≤ λ |d|²/2 ≤ λ |X − Q|²/2,

with λ the largest eigenvalue of H to that side over the disk, or zero. No ball that touches at Q
and is smaller than 1/λ contains X. Tangents that leave the plane, or tangent planes that differ at
a joint, by an angle ε move the surface into the ball by at most ε²ρ, with ρ < `SAFETY`/λ: a hundred
times less than rounding.

The ranges of these functions come from Bernstein coefficients over small boxes in (x, τ), each in
the plane's axes rotated to its own direction from P.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray
from contiga.search.balls.spans import (
    Span,
    basis,
    elevated,
    less_a_factor,
    quotient,
    restriction,
    spans_of,
)
from contiga.search.hierarchy.table_types import Tables

PLANE_TOL = 1e-9
"""Largest angle of tangents at a pole to their plane, and of tangent planes at a joint."""
SAFETY = 0.99
"""Share of 1/λ that is claimed."""
N_BOXES = 96
"""Number of boxes around a pole."""
MAX_LENGTH = (0.25, 1.0 / 16.0)
"""Largest length of a box, as a share of its distance from the pole, and of the element."""
MARGIN = 1.0 / 32.0
"""Share by which the boxes of the proof extend beyond the cells of a cap."""


class Cap(NamedTuple):
    """The proved extent and ball radii of the surface about a pole."""

    reach: float
    """Extent in the elements, as a share of them."""
    radii: tuple[float, float]
    """Radii of inner and outer balls that contain no other point of the cap."""
    bend: float
    """Largest change of the slope of the surface over the tangent plane, per length."""


class _Bands(NamedTuple):
    """Bounds of an element between steps away from the pole, one row a band."""

    is_sound: NDArray[np.bool_]
    """Whether the map preserves orientation there."""
    low: FloatArray
    """Least eigenvalue of H."""
    high: FloatArray
    """Largest eigenvalue of H."""
    inner_radius: FloatArray
    """Least distance of the end of a band from the pole."""
    outer_radius: FloatArray
    """Largest distance of a band from the pole."""
    area: FloatArray
    """Least det(V, U)."""
    speed: FloatArray
    """Largest |S_τ|."""


def cap_over(
    tables: Tables, ring: list[tuple[int, int, bool]], edges: FloatArray, tolerance: float
) -> Cap | None:
    """Return the cap over a ring (element, side, whether x runs backwards), up to one of `edges`.

    `edges` are rising shares of the elements; the cap ends where the balls are largest
    (`_best_cap`). None if nothing is proved. Points within `tolerance`, a length, are one.
    """
    nets = [_net(tables, e, side, back) for e, side, back in ring]
    # Whether S_τ × S_x runs along S_u × S_v (1) or against it (−1).
    senses = [(1 if side in (0, 3) else -1) * (-1 if back else 1) for _, side, back in ring]
    pole = nets[0][0, 0, :3] / nets[0][0, 0, 3]
    if not min(net[:, :, 3].min() for net in nets) > 0.0:
        return None
    for net in nets:
        net[:, :, :3] -= net[:, :, 3:] * pole
        if not np.abs(net[:, 0, :3]).max() <= tolerance * net[:, :, 3].min():
            return None
    # Axes of the tangent plane and its normal, about which the elements follow each other.
    n = np.zeros(3)
    for net in nets:
        n += np.cross(net[:-1, 1, :3], net[1:, 1, :3]).sum(axis=0)
    length = float(np.linalg.norm(n))
    if not length > 0.0 or len(set(senses)) > 1:
        return None
    n /= length
    a = np.cross(n, np.eye(3)[np.abs(n).argmin()])
    a /= np.linalg.norm(a)
    axes = np.stack([a, np.cross(n, a), n], axis=1)
    for net in nets:
        net[:, :, :3] = np.einsum("ijc,cd->ijd", net[:, :, :3], axes)
    charts = [less_a_factor(net[:, :, :3].swapaxes(1, 2)) for net in nets]  # (p + 1, 3, q)
    size = max(float(np.abs(chart).max()) for chart in charts)
    if not max(float(np.abs(chart[:, 2, 0]).max()) for chart in charts) <= PLANE_TOL * size:
        return None
    # Bands end at the edges and the margin beyond them, and between if they would be too long.
    band_ends = np.unique(np.minimum(np.concatenate([[0.0], edges, edges * (1.0 + MARGIN)]), 1.0))
    bands = [band_ends[:1]]
    for low, high in pairwise(band_ends.tolist()):
        longest = min(max(MAX_LENGTH[0] * low, high / 4.0), MAX_LENGTH[1])
        bands.append(np.linspace(low, high, math.ceil((high - low) / longest - 1e-9) + 1)[1:])
    steps = np.concatenate(bands)
    weights = [net[:, :, 3] for net in nets]
    count = max(2, math.ceil(N_BOXES / len(nets)))
    with np.errstate(over="ignore", invalid="ignore"):  # far from the pole numbers may overflow
        results = [_bands(c, w, steps, count) for c, w in zip(charts, weights, strict=True)]
    angle = sum(part[1] for part in results)
    if not abs(angle - 2.0 * math.pi) < 1e-6:
        return None
    joints = _joint_bound(charts, weights, tolerance)
    return _best_cap([part[0] for part in results], joints, steps, edges, senses[0])


def _net(tables: Tables, e: int, side: int, is_backwards: bool) -> FloatArray:
    """Return a copy of an element's coefficients (p + 1, q + 1, 4) along a side and away from it.

    They are homogeneous, relative to the origin of the body's first element.
    """
    row = tables.elements.table[e]
    p, q = row["degree"].tolist()
    start = int(row["bernstein"])
    net = tables.elements.coefs[start : start + 4 * (p + 1) * (q + 1)].reshape(p + 1, q + 1, 4)
    net = net.copy()
    net[:, :, :3] += net[:, :, 3:] * (row["origin"] - tables.elements.table[0]["origin"])
    if side < 2:
        net = net.swapaxes(0, 1)
    if side & 1:
        net = net[:, ::-1]
    return np.ascontiguousarray(net[::-1] if is_backwards else net)


def _bands(chart: FloatArray, w: FloatArray, steps: FloatArray, count: int) -> tuple[_Bands, float]:
    """Return bounds of an element between `steps` from the pole, and its angle at the pole, rad.

    `chart` (p + 1, 3, q) and `w` (p + 1, q + 1) are the coefficients of B and of the weight; each
    band is divided into `count` boxes along x.
    """
    q = w.shape[1] - 1
    high = np.zeros((len(chart), 1))
    if q > 1:
        high = less_a_factor(chart[:, 2])
    nets = np.stack([elevated(x, q) for x in (chart[:, 0], chart[:, 1], high, w)])
    x = np.arange(count + 1) / count
    along = restriction(len(w) - 1, x[:-1], x[1:])
    across = restriction(q, steps[:-1], steps[1:])
    parts = np.einsum("kcd,nxad->nacxk", across, np.einsum("xab,nbd->nxad", along, nets))
    parts = np.ascontiguousarray(parts)
    widths = np.full((count, len(steps) - 1), 1.0 / count), np.diff(steps) + np.zeros((count, 1))
    tau = Span(steps[:-1], steps[1:])
    middle = parts.mean(axis=(1, 2))
    length = np.hypot(middle[0], middle[1])
    cos, sin = middle[:2] / np.maximum(length, 1e-300)
    parts[0], parts[1] = cos * parts[0] + sin * parts[1], cos * parts[1] - sin * parts[0]
    weights = spans_of(parts[3], widths)
    c: list[list[Span]] = []
    ends: list[Span] = []
    for k in range(3):
        centre = (length, np.zeros_like(length), middle[2])[k] / middle[3]
        net = parts[k] - centre * parts[3]
        spans = quotient(spans_of(net, widths), weights)
        spans[0] = spans[0] + Span(centre, centre)
        c.append(spans)
        last = parts[k, :, -1] / parts[3, :, -1]
        ends.append(Span(last.min(axis=0), last.max(axis=0)))
    # The angle of the tangents of the element around the pole.
    tangents = basis(len(chart) - 1, np.arange(count + 1) / count) @ chart[:, :2, 0]
    cross = tangents[:-1, 0] * tangents[1:, 1] - tangents[:-1, 1] * tangents[1:, 0]
    angle = float(np.arctan2(cross, (tangents[:-1] * tangents[1:]).sum(axis=1)).sum())
    return _worst_of_boxes(c, c[2], ends, tau), angle


def _worst_of_boxes(c: list[list[Span]], g: list[Span], ends: list[Span], tau: Span) -> _Bands:
    """Return bounds for each band that hold in all its boxes.

    c[k] and g are ranges of component k and of G and of their derivatives, in the order of
    `ORDERS`, each (boxes, bands), in the axes of each box. `ends` are the ranges of c and G at the
    far end of each band, `tau` the ranges of its parameter. Bounds hold only where `is_sound`.
    """
    u = [c[k][1] for k in range(2)]
    v = [c[k][0] + tau * c[k][2] for k in range(2)]
    area = v[0] * u[1] - v[1] * u[0]
    turn = c[0][0] * u[1] - c[1][0] * u[0]
    is_sound = (c[0][0].low > 0.0) & (turn.low > 0.0) & (area.low > 0.0)
    safe_area = Span(np.maximum(area.low, 1e-300), np.maximum(area.high, 1e-300))
    up = g[0].times(2.0) + tau * g[2]
    m = [(up * u[1] - g[1] * v[1]) / safe_area, (g[1] * v[0] - up * u[0]) / safe_area]
    uu = g[3] - m[0] * c[0][3] - m[1] * c[1][3]
    uv = g[1] + tau * (g[4] - m[0] * c[0][4] - m[1] * c[1][4])
    d = [(c[k][2].times(2.0) + tau * c[k][5]) for k in range(2)]
    vv = g[0].times(2.0) + tau * (g[2].times(4.0) + tau * g[5] - m[0] * d[0] - m[1] * d[1])
    zero = Span(np.zeros_like(area.low), np.zeros_like(area.low))
    a = [(zero - v[1]) / safe_area, v[0] / safe_area]  # dual to U and V
    b = [u[1] / safe_area, (zero - u[0]) / safe_area]
    xx = uu * a[0] * a[0] + (uv * a[0] * b[0]).times(2.0) + vv * b[0] * b[0]
    xy = uu * a[0] * a[1] + uv * (a[0] * b[1] + a[1] * b[0]) + vv * b[0] * b[1]
    yy = uu * a[1] * a[1] + (uv * a[1] * b[1]).times(2.0) + vv * b[1] * b[1]
    high = 0.5 * (xx.high + yy.high) + np.hypot(0.5 * (xx.high - yy.high), xy.size)
    low = 0.5 * (xx.low + yy.low) - np.hypot(0.5 * (xx.low - yy.low), xy.size)
    rise = tau * up
    return _Bands(
        np.all(is_sound, axis=0),
        low.min(axis=0),
        high.max(axis=0),
        (tau.high * ends[0].low).min(axis=0),
        (tau.high * np.hypot(c[0][0].size, c[1][0].size)).max(axis=0),
        area.low.min(axis=0),
        np.sqrt(v[0].size ** 2 + v[1].size ** 2 + rise.size**2).max(axis=0),
    )


def _joint_bound(charts: list[FloatArray], weights: list[FloatArray], tolerance: float) -> float:
    """Return a bound of |det(U, V, U')| over all joints of the elements: it measures their kinks.

    The bound is the largest value at Chebyshev nodes times the Lebesgue constant. It is infinite
    where elements do not share their curves within `tolerance`.
    """
    worst = 0.0
    for k in range(len(charts)):
        before, after = (charts[k - 1], weights[k - 1]), (charts[k], weights[k])
        count = 6 * max(w.shape[1] - 1 for w in (before[1], after[1]))
        # Chebyshev's nodes: between them no polynomial is more than `lebesgue` times larger.
        places = 0.5 - 0.5 * np.cos((np.arange(count) + 0.5) * math.pi / count)
        lebesgue = 1.0 + 2.0 / math.pi * math.log(count)
        a, x, s, w = _edge_values(before, -1, places)
        b, y, _, z = _edge_values(after, 0, places)
        min_weight = min(before[1].min(), after[1].min())
        gap = a * z[:, None] - b * w[:, None]
        if not lebesgue * np.abs(gap).max() <= tolerance * min_weight**2:
            return math.inf
        volume = (np.cross(x, s) * y).sum(axis=1)
        worst = max(worst, lebesgue * float(np.abs(volume).max()) / min_weight**6)
    return worst


def _edge_values(
    element: tuple[FloatArray, FloatArray], end: int, places: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return numerators of C, C_x and S_τ (n, 3), and weights w (n,), at places (n,) of an edge.

    `element` is (chart, weights), `end` the first (0) or last (−1) edge; the denominators are w, w²
    and w².
    """
    chart, w = element
    q = w.shape[1] - 1
    p = len(w) - 1
    low, high = (0, 1) if end == 0 else (-2, -1)
    values, slopes = basis(q - 1, places), basis(q, places)
    b = values @ chart[end].T
    b_x = values @ (p * (chart[high] - chart[low])).T
    w_0, w_x = slopes @ w[end], slopes @ (p * (w[high] - w[low]))
    w_t = basis(q - 1, places) @ (q * np.diff(w[end]))
    b_t = np.zeros_like(b)
    if q > 1:
        b_t = basis(q - 2, places) @ ((q - 1) * np.diff(chart[end], axis=1)).T
    t = places[:, None]
    s_t = (b + t * b_t) * w_0[:, None] - t * b * w_t[:, None]
    return b, b_x * w_0[:, None] - b * w_x[:, None], s_t, w_0


def _best_cap(
    bands: list[_Bands], joints: float, steps: FloatArray, edges: FloatArray, sense: int
) -> Cap | None:
    """Return the cap that ends at the edge where its balls are largest; None if none is proved.

    Largest is the sum of both radii, each counted up to half the cap's outer radius; the first of
    equal edges. `sense` is the sense of S_τ × S_x along the normal.
    """
    is_sound = np.logical_and.accumulate(np.all([band.is_sound for band in bands], axis=0))
    low = np.minimum.accumulate(np.min([band.low for band in bands], axis=0))
    high = np.maximum.accumulate(np.max([band.high for band in bands], axis=0))
    inner_radius = np.min([band.inner_radius for band in bands], axis=0)
    outer_radius = np.maximum.accumulate(np.max([band.outer_radius for band in bands], axis=0))
    area = np.minimum.accumulate(np.min([band.area for band in bands], axis=0))
    speed = np.maximum.accumulate(np.max([band.speed for band in bands], axis=0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        is_sound &= joints * speed <= PLANE_TOL * area**2
        radii = SAFETY / np.maximum(np.stack([-low, high] if sense > 0 else [high, -low]), 0.0)
    best_score: float = 0.0
    result: Cap | None = None
    for edge in edges.tolist():
        last = int(np.searchsorted(steps, edge, side="right")) - 2
        wide_bands = np.flatnonzero(inner_radius >= outer_radius[last])
        if last < 0 or len(wide_bands) == 0 or not is_sound[k := int(wide_bands[0])] or k < last:
            continue
        score = float(np.minimum(radii[:, k], 0.5 * outer_radius[last]).sum())
        if score > best_score:
            best_score = score
            both = (float(radii[0, k]), float(radii[1, k]))
            result = Cap(edge, both, float(max(-low[k], high[k], 0.0)))
    return result
