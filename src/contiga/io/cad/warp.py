"""Recomputed p-curves: for changed surface parameters, and for edges that are given only in space.

A circular arc of half-angle α as a rational quadratic over [k, k + h] passes the angle θ at
``k + h/2 · (1 + tan((θ − θm)/2) / tan(α/2))``, θm its middle (stereographic projection). Patches
made from cylinders, spheres, … have their knots at true angles, so that the map leaves the knots
unchanged and p-curves given in angles change only between them.

Edges are projected onto their surface, over its seams and for any number of turns.
"""

from __future__ import annotations

from collections.abc import Callable
from math import comb

import numpy as np

from contiga.arrays.ordered import product, solve
from contiga.geometry.bezier import extract_curve
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.kernels.trim_build_nb import monotone_pieces
from contiga.geometry.kernels.trim_nb import parameter_at
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.chart import Chart
from contiga.records import FloatArray

DEGREE = 5
SAME_TOL = 1e-9
"""Distance up to which borders of pieces coincide, over the whole: rounding."""
POLE_STEP = 1e-4
"""Distance from a pole at which its parameter is read off, as a share of the edge."""
MAX_SECANTS = 8
"""Largest number of secants for a knot crossing (Illinois rule), more than are needed."""
N_CHECKS = 65
"""Points of an edge that must lie on its surface."""
FIT_TOL = 1e-10
"""Largest deviation of a recomputed p-curve, as a share of the domain."""


class AngleMap:
    """Angle → parameter of a rational quadratic circle with `breaks` at true angles."""

    def __init__(self, breaks: FloatArray) -> None:
        self.breaks = np.asarray(breaks, dtype=np.float64)

    def __call__(self, angle: FloatArray) -> FloatArray:
        """Return parameters for angles, which are clamped to the range of the breaks."""
        x = np.clip(np.asarray(angle, dtype=np.float64), self.breaks[0], self.breaks[-1])
        k = np.clip(np.searchsorted(self.breaks, x, side="right") - 1, 0, len(self.breaks) - 2)
        low, half = self.breaks[k], 0.5 * (self.breaks[k + 1] - self.breaks[k])
        return low + half * (1.0 + np.tan(0.5 * (x - low - half)) / np.tan(0.5 * half))


def identity(x: FloatArray) -> FloatArray:
    """Return the parameter unchanged: it is the same in both forms."""
    return np.asarray(x, dtype=np.float64)


Map = Callable[[FloatArray], FloatArray]


def map_pcurve(curve: NurbsCurve, maps: tuple[Map, Map], span: FloatArray) -> NurbsCurve:
    """Return `curve` in (u, v) under the two maps, to `FIT_TOL` · span (2,), the patch's extent.

    Without maps it is the same object. Curves along u or v become lines, with their parameter;
    anything else becomes a chain of quintic pieces, cut at the maps' breaks and halved until each
    fits, or is 2^-20 of the whole.
    """
    if maps[0] is identity and maps[1] is identity:
        return curve
    points = curve.control_points[:, :2]
    extent = np.ptp(points, axis=0)
    level = [axis for axis in range(2) if extent[axis] <= 1e-13 * max(span[axis], 1e-300)]
    if level:
        axis = 1 - level[0]
        if np.abs(np.diff(points[:, axis])).sum() <= extent[axis] * (1.0 + 1e-12):
            a, b = curve.domain
            u, v = points[[0, -1]].T
            return NurbsCurve(1, [a, a, b, b], np.stack([maps[0](u), maps[1](v)], axis=1))

    def image(t: FloatArray) -> FloatArray:
        uv = curve.evaluate(t)
        return np.stack([maps[0](uv[:, 0]), maps[1](uv[:, 1])], axis=1)

    slack = FIT_TOL * np.maximum(span, 1e-300)
    return _fit_quintics(
        image, _break_parameters(curve, maps), lambda uv: np.broadcast_to(slack, uv.shape)
    )


def _fit_quintics(
    image: Callable[[FloatArray], FloatArray],
    borders: FloatArray,
    allowed: Callable[[FloatArray], FloatArray],
) -> NurbsCurve:
    """Return a chain of quintics through ``image(t)`` (k, 2), which is smooth between `borders`.

    A piece interpolates at the Chebyshev nodes `_NODES`. Pieces are halved until they miss by no
    more than ``allowed(uv)`` (k, 2) at `_CHECKS`, or are 2^-20 of the whole.
    """
    smallest = (borders[-1] - borders[0]) * 2.0**-20
    spans = np.stack([borders[:-1], borders[1:]], axis=1)
    starts, pieces = [], []
    while len(spans):  # all of one size at once
        a, b = spans[:, :1], spans[:, 1:]
        t = np.clip(a + (b - a) * np.concatenate([_NODES, _CHECKS]), a, b)
        uv = image(t.ravel()).reshape(*t.shape, 2)
        at_nodes, at_checks = uv[:, : DEGREE + 1], uv[:, DEGREE + 1 :]
        control = np.array([product(_TO_BERNSTEIN, points) for points in at_nodes])
        control[:, [0, -1]] = at_nodes[:, [0, -1]]
        fitted = np.array([product(_AT_CHECKS, points) for points in control])
        slack = allowed(at_checks.reshape(-1, 2)).reshape(at_checks.shape)
        fits = (np.abs(fitted - at_checks) <= slack).all(axis=(1, 2))
        done = fits | (spans[:, 1] - spans[:, 0] <= smallest)
        starts.append(spans[done, 0])
        pieces.append(control[done])
        a, b = spans[~done].T
        middle = 0.5 * (a + b)
        spans = np.stack([a, middle, middle, b], axis=1).reshape(-1, 2)
    breaks = np.concatenate([*starts, borders[-1:]])
    order = np.argsort(breaks[:-1])
    chain = np.concatenate(pieces)[order]
    points = np.concatenate([chain[0, :1], chain[:, 1:].reshape(-1, 2)])
    multiplicities = np.full(len(breaks), DEGREE)
    multiplicities[[0, -1]] += 1
    return NurbsCurve(DEGREE, np.repeat([*breaks[order], breaks[-1]], multiplicities), points)


def project_edge(
    curve: NurbsCurve, edge: NurbsCurve, surface: NurbsSurface, tolerance: float
) -> NurbsCurve | None:
    """Return the p-curve of `edge` on `surface`, from a rough one with the same parameters.

    It is a chain of quintics, cut at the knots of the edge and where it crosses knots of the
    surface, to `FIT_TOL` of the domain, or of the size in space. Every point is projected by
    Gauss-Newton, which converges at once since edges lie on their surfaces. `curve` may cross
    seams of a closed surface. None if one of `N_CHECKS` points is farther away than `tolerance`,
    length: the edge leaves the surface.
    """
    chart = Chart(surface)
    a, b = edge.domain
    t = np.linspace(a, b, N_CHECKS)

    def foot(t: FloatArray) -> FloatArray:
        rough = curve.evaluate(np.clip(t, *curve.domain))[:, :2]
        return chart.project_from(rough, edge.evaluate(t))

    def image(t: FloatArray) -> FloatArray:
        uv = foot(t)
        at_pole = chart.is_pole(uv).any(axis=1)
        if at_pole.any():
            # At a pole a parameter is its limit along the edge, by quadratic extrapolation.
            step = np.where(t[at_pole] < 0.5 * (a + b), 1.0, -1.0) * POLE_STEP * (b - a)
            first, second, third = (foot(t[at_pole] + k * step) for k in (1, 2, 3))
            uv[at_pole] = 3.0 * first - 3.0 * second + third
        return uv

    distance = np.linalg.norm(chart.points(image(t)) - edge.evaluate(t), axis=1).max()
    if distance > tolerance:
        return None
    span = chart.high - chart.low
    near = FIT_TOL * chart.size

    def allowed(uv: FloatArray) -> FloatArray:
        # Next to a pole one parameter is nearly undetermined: the place decides.
        return np.maximum(FIT_TOL * span, near / np.maximum(chart.speed(uv), 1e-300))

    crossings = _knot_crossings(image, np.union1d(t, curve.knots), chart)
    borders = np.clip(np.concatenate([edge.knots, crossings]), a, b)
    return _fit_quintics(image, _distinct(borders), allowed)


def _knot_crossings(
    image: Callable[[FloatArray], FloatArray], t: FloatArray, chart: Chart
) -> FloatArray:
    """Return the parameters (k,) at which an image crosses knots of the surface, its kinks.

    Crossings are sought between the samples `t`, ascending, for u and then for v, with the knots of
    all turns of a closed direction; a double one between two samples is missed. Each is found by
    `MAX_SECANTS` steps of the Illinois rule.
    """
    uv = image(t)
    crossings = []
    for axis, knots in enumerate(chart.surface.knots):
        levels = np.unique(knots)
        period = chart.periods[axis]
        if period > 0.0:
            first, last = (
                np.floor((uv[:, axis].min() - levels[0]) / period),
                np.ceil((uv[:, axis].max() - levels[0]) / period),
            )
            levels = np.unique(levels + period * np.arange(first, last + 1.0)[:, None])
        low, high = uv[:-1, axis, None], uv[1:, axis, None]
        row, level = np.nonzero((low - levels) * (high - levels) < 0.0)
        a, b, values = t[row], t[row + 1], uv[:, axis]
        miss_a, miss_b = values[row] - levels[level], values[row + 1] - levels[level]
        for _ in range(MAX_SECANTS if len(row) else 0):
            c = a - miss_a * (b - a) / np.where(miss_a == miss_b, 1.0, miss_b - miss_a)
            miss = image(c)[:, axis] - levels[level]
            is_before = miss_a * miss > 0.0
            a, miss_a = np.where(is_before, c, a), np.where(is_before, miss, 0.5 * miss_a)
            b, miss_b = np.where(is_before, b, c), np.where(is_before, 0.5 * miss_b, miss)
        crossings.append(np.where(np.abs(miss_a) < np.abs(miss_b), a, b))
    return np.concatenate(crossings)


def _distinct(borders: FloatArray) -> FloatArray:
    """Return `borders` ascending, without those within `SAME_TOL` of the whole after another.

    First and last stay.
    """
    ascending = np.unique(borders)
    near = SAME_TOL * (ascending[-1] - ascending[0])
    keep = np.diff(ascending, prepend=-np.inf) > near
    keep[-1] = True
    if len(ascending) > 2 and ascending[-1] - ascending[-2] <= near:
        keep[-2] = False
    return ascending[keep]


def _break_parameters(curve: NurbsCurve, maps: tuple[Map, Map]) -> FloatArray:
    """Return the parameters (k,) of `curve` at its knots and where it crosses a break of a map.

    They are distinct and ascending; touching a break is no crossing.
    """
    bezier = extract_curve(curve)
    coefs = np.ascontiguousarray(bezier.coefs[..., [0, 1, 3]])
    degree = coefs.shape[1] - 1
    pieces, source, part = monotone_pieces(coefs, np.full(len(coefs), degree, dtype=np.int32))
    borders = [np.asarray(bezier.breaks)]
    for piece, segment, (a, b) in zip(pieces, source, part, strict=True):
        low, width = bezier.breaks[segment], bezier.breaks[segment + 1] - bezier.breaks[segment]
        for axis, warp in enumerate(maps):
            if not isinstance(warp, AngleMap):
                continue
            values = np.sort([piece[0, axis] / piece[0, 2], piece[-1, axis] / piece[-1, 2]])
            for level in warp.breaks:
                if values[0] < level < values[1]:
                    t = a + (b - a) * parameter_at(piece, degree, axis, level)
                    borders.append(np.array([low + t * width]))
    return _distinct(np.concatenate(borders))


_NODES = 0.5 * (1.0 - np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE))
_CHECKS = 0.5 * (_NODES[:-1] + _NODES[1:])


def _bernstein(t: FloatArray) -> FloatArray:
    k = np.arange(DEGREE + 1)
    binomials = np.array([comb(DEGREE, int(i)) for i in k], dtype=np.float64)
    return binomials * t[:, None] ** k * (1.0 - t[:, None]) ** (DEGREE - k)


_TO_BERNSTEIN = solve(_bernstein(_NODES), np.eye(DEGREE + 1))
_AT_CHECKS = _bernstein(_CHECKS)
