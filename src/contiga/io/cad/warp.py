"""p-curves drawn anew: where a surface's parameters change, and where they were only near.

A circular arc of half-angle α as a rational quadratic over [k, k + h] passes the angle θ at
``k + h/2 · (1 + tan((θ − θm)/2) / tan(α/2))``, θm its middle (stereographic projection). Patches
made from cylinders, spheres, … have their knots at true angles, so that the map keeps them and
p-curves given in angles only need to be bent between them.

p-curves that were approximated from an edge are brought onto it by projection.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contiga.geometry.bezier import extract_curve
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.kernels.trim_build_nb import monotone_pieces
from contiga.geometry.kernels.trim_nb import parameter_at
from contiga.geometry.surface import NurbsSurface
from contiga.num.ordered import product, solve
from contiga.records import FloatArray

DEGREE = 5
STEPS = 4
CHECKED = 65
TOLERANCE = 1e-10
"""Largest deviation of a bent p-curve, as a share of the domain."""


class AngleMap:
    """Angle → parameter of a rational quadratic circle with `breaks` at true angles."""

    def __init__(self, breaks: FloatArray) -> None:
        self.breaks = np.asarray(breaks, dtype=np.float64)

    def __call__(self, angle: FloatArray) -> FloatArray:
        """Parameters for angles, which are clamped to the breaks' range."""
        x = np.clip(np.asarray(angle, dtype=np.float64), self.breaks[0], self.breaks[-1])
        k = np.clip(np.searchsorted(self.breaks, x, side="right") - 1, 0, len(self.breaks) - 2)
        low, half = self.breaks[k], 0.5 * (self.breaks[k + 1] - self.breaks[k])
        return low + half * (1.0 + np.tan(0.5 * (x - low - half)) / np.tan(0.5 * half))


def identity(x: FloatArray) -> FloatArray:
    """No change: the direction's parameter is the same in both forms."""
    return np.asarray(x, dtype=np.float64)


Map = Callable[[FloatArray], FloatArray]


def bent(curve: NurbsCurve, maps: tuple[Map, Map], span: FloatArray) -> NurbsCurve:
    """`curve` in (u, v) under the two maps, to `TOLERANCE` · span.

    Lines along u or v stay lines; anything else becomes a chain of quintic pieces, cut at the
    maps' breaks and halved until each fits.
    """
    warped = [axis for axis in range(2) if maps[axis] is not identity]
    if not warped:
        return curve
    points = curve.control_points[:, :2]
    reach = np.ptp(points, axis=0)
    level = [axis for axis in range(2) if reach[axis] <= 1e-13 * max(span[axis], 1e-300)]
    if level:
        along = points[[0, -1]].copy()
        if np.abs(np.diff(points[:, 1 - level[0]])).sum() <= reach[1 - level[0]] * (1.0 + 1e-12):
            a, b = curve.domain
            ends = np.stack([maps[0](along[:, 0]), maps[1](along[:, 1])], axis=1)
            return NurbsCurve(1, [a, a, b, b], ends)

    def mapped(t: FloatArray) -> FloatArray:
        uv = curve.evaluate(t)
        return np.stack([maps[0](uv[:, 0]), maps[1](uv[:, 1])], axis=1)

    return fitted(mapped, _borders(curve, maps), span)


def fitted(
    image: Callable[[FloatArray], FloatArray], borders: FloatArray, span: FloatArray
) -> NurbsCurve:
    """A chain of quintics through ``image(t)`` (k, 2), smooth between `borders`.

    Pieces are halved until they miss by no more than `TOLERANCE` · span in between.
    """
    tolerance = TOLERANCE * np.maximum(span, 1e-300)
    smallest = (borders[-1] - borders[0]) * 2.0**-20
    todo = np.stack([borders[:-1], borders[1:]], axis=1)
    starts, pieces = [], []
    while len(todo):  # all of one size at once
        control, miss = _quintics(image, todo)
        done = np.all(miss <= tolerance, axis=1) | (todo[:, 1] - todo[:, 0] <= smallest)
        starts.append(todo[done, 0])
        pieces.append(control[done])
        a, b = todo[~done].T
        middle = 0.5 * (a + b)
        todo = np.stack([a, middle, middle, b], axis=1).reshape(-1, 2)
    breaks = np.concatenate([*starts, borders[-1:]])
    order = np.argsort(breaks[:-1])
    chain = np.concatenate(pieces)[order]
    points = np.concatenate([chain[0, :1], chain[:, 1:].reshape(-1, 2)])
    times = np.full(len(breaks), DEGREE)
    times[[0, -1]] += 1
    return NurbsCurve(DEGREE, np.repeat([*breaks[order], breaks[-1]], times), points)


def on_edge(
    curve: NurbsCurve, edge: NurbsCurve, surface: NurbsSurface, tolerance: float
) -> NurbsCurve | None:
    """The p-curve of `edge` on `surface`, from a rough one with the same parameters.

    Every point of the edge is projected by Gauss-Newton, which converges at once since edges lie
    on their surfaces. None if a point stays farther away than `tolerance` (length): the edge then
    runs over a seam or leaves the surface.
    """
    low, high = np.array(surface.domain).T

    def image(t: FloatArray) -> FloatArray:
        uv = np.clip(curve.evaluate(np.clip(t, *curve.domain))[:, :2], low, high)
        points = edge.evaluate(t)
        for _ in range(STEPS):
            first = surface.derivatives(uv, 1)
            J = np.stack([first[:, 1, 0], first[:, 0, 1]], axis=2)
            step = np.linalg.pinv(J) @ (points - first[:, 0, 0])[..., None]
            uv = np.clip(uv + step[..., 0], low, high)
        return uv

    a, b = edge.domain
    t = np.linspace(a, b, CHECKED)
    missed = np.linalg.norm(surface.evaluate(image(t)) - edge.evaluate(t), axis=1).max()
    if missed > tolerance:
        return None
    knots = np.unique(np.concatenate([edge.knots, curve.knots]))
    borders = knots[(knots > a + 1e-9 * (b - a)) & (knots < b - 1e-9 * (b - a))]
    return fitted(image, np.concatenate([[a], borders, [b]]), high - low)


def _borders(curve: NurbsCurve, maps: tuple[Map, Map]) -> FloatArray:
    """Parameters of `curve` at its own knots and where it crosses a break of a map."""
    bezier = extract_curve(curve)
    coefs = np.ascontiguousarray(bezier.coefs[..., [0, 1, 3]])
    degree = coefs.shape[1] - 1
    pieces, source, part = monotone_pieces(coefs, np.full(len(coefs), degree, dtype=np.int32))
    found = [np.asarray(bezier.breaks)]
    for piece, s, (a, b) in zip(pieces, source, part, strict=True):
        low, width = bezier.breaks[s], bezier.breaks[s + 1] - bezier.breaks[s]
        for axis, warp in enumerate(maps):
            if not isinstance(warp, AngleMap):
                continue
            values = np.sort([piece[0, axis] / piece[0, 2], piece[-1, axis] / piece[-1, 2]])
            for level in warp.breaks:
                if values[0] < level < values[1]:
                    t = a + (b - a) * parameter_at(piece, degree, axis, level)
                    found.append(np.array([low + t * width]))
    borders = np.unique(np.concatenate(found))
    keep = np.diff(borders, prepend=-np.inf) > 1e-9 * (borders[-1] - borders[0])
    keep[-1] = True
    if len(borders) > 2 and borders[-1] - borders[-2] <= 1e-9 * (borders[-1] - borders[0]):
        keep[-2] = False
    return borders[keep]


_NODES = 0.5 * (1.0 - np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE))
_CHECKS = 0.5 * (_NODES[:-1] + _NODES[1:])


def _bernstein(t: FloatArray) -> FloatArray:
    from math import comb

    k = np.arange(DEGREE + 1)
    binomials = np.array([comb(DEGREE, int(i)) for i in k], dtype=np.float64)
    return binomials * t[:, None] ** k * (1.0 - t[:, None]) ** (DEGREE - k)


_TO_BERNSTEIN = solve(_bernstein(_NODES), np.eye(DEGREE + 1))
_AT_CHECKS = _bernstein(_CHECKS)


def _quintics(
    image: Callable[[FloatArray], FloatArray], parts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Quintics (n, 6, 2) through the image of `parts` (n, 2), and largest misses (n, 2) between."""
    a, b = parts[:, :1], parts[:, 1:]
    t = np.clip(a + (b - a) * np.concatenate([_NODES, _CHECKS]), a, b)
    mapped = image(t.ravel()).reshape(*t.shape, 2)
    through, between = mapped[:, : DEGREE + 1], mapped[:, DEGREE + 1 :]
    control = np.array([product(_TO_BERNSTEIN, points) for points in through])
    control[:, [0, -1]] = through[:, [0, -1]]
    checked = np.array([product(_AT_CHECKS, points) for points in control])
    return control, np.abs(checked - between).max(axis=1)
