"""Parameters of circles: from the angle of an analytic surface to that of its rational form.

A circular arc of half-angle α as a rational quadratic over [k, k + h] passes the angle θ at
``k + h/2 · (1 + tan((θ − θm)/2) / tan(α/2))``, θm its middle (stereographic projection). Patches
made from cylinders, spheres, … have their knots at true angles, so that the map keeps them and
p-curves given in angles only need to be bent between them.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from contiga.geometry._trim_build_nb import monotone_pieces
from contiga.geometry._trim_nb import parameter_at
from contiga.geometry.bezier import extract_curve
from contiga.geometry.curve import NurbsCurve
from contiga.records import FloatArray

DEGREE = 5
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
            mapped = np.stack([maps[0](along[:, 0]), maps[1](along[:, 1])], axis=1)
            return NurbsCurve(1, [a, a, b, b], mapped)
    return _fitted(curve, maps, span)


def _fitted(curve: NurbsCurve, maps: tuple[Map, Map], span: FloatArray) -> NurbsCurve:
    borders = _borders(curve, maps)
    tolerance = TOLERANCE * np.maximum(span, 1e-300)
    pieces: list[FloatArray] = []
    breaks = [float(borders[0])]
    todo = list(pairwise(borders))[::-1]
    smallest = (borders[-1] - borders[0]) * 2.0**-20
    while todo:
        a, b = todo.pop()
        control, miss = _quintic(curve, maps, a, b)
        if np.all(miss <= tolerance) or b - a <= smallest:
            pieces.append(control)
            breaks.append(float(b))
        else:
            middle = 0.5 * (a + b)
            todo += [(middle, b), (a, middle)]
    points = np.concatenate([pieces[0][:1], *(piece[1:] for piece in pieces)])
    times = np.full(len(breaks), DEGREE)
    times[[0, -1]] += 1
    return NurbsCurve(DEGREE, np.repeat(breaks, times), points)


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


_TO_BERNSTEIN = np.linalg.inv(_bernstein(_NODES))
_AT_CHECKS = _bernstein(_CHECKS)


def _quintic(
    curve: NurbsCurve, maps: tuple[Map, Map], a: float, b: float
) -> tuple[FloatArray, FloatArray]:
    """Quintic through the mapped curve on [a, b], and its largest miss (2,) in between."""
    t = np.concatenate([_NODES, _CHECKS])
    points = curve.evaluate(np.clip(a + (b - a) * t, a, b))
    mapped = np.stack([maps[0](points[:, 0]), maps[1](points[:, 1])], axis=1)
    control = _TO_BERNSTEIN @ mapped[: DEGREE + 1]
    control[[0, -1]] = mapped[[0, DEGREE]]
    return control, np.abs(_AT_CHECKS @ control - mapped[DEGREE + 1 :]).max(axis=0)
