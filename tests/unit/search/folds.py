"""Folds of two planes, whose feet are known."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.geometry.edges import BodyEdge, EdgeUse


def ring(low, high):
    corners = [[low, 0, 0], [high, 0, 0], [high, 1, 0], [low, 1, 0]]
    return [cg.shapes.line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def _planes(turn, *ends):
    """Two planes that meet along y at x = z = 0, bent down by `turn`, each over a range of x."""
    c, s = np.cos(0.5 * turn), np.sin(0.5 * turn)

    def corners(x, lean):
        return [[x * c, y, lean * x * s] for y in (-1.0, 1.0)]

    sheets = []
    for lean, (low, high) in zip((1.0, -1.0), ends, strict=True):
        a, b = corners(low, lean), corners(high, lean)
        sheets.append(cg.shapes.bilinear(a[0], b[0], a[1], b[1]))
    return sheets


def natural_fold(turn):
    """Two planes that meet in a crease along y at x = z = 0, bent down by `turn`."""
    return cg.Body(_planes(turn, (-1.0, 0.0), (0.0, 1.0)))


def trimmed_fold(turn, gap=0.0):
    """The same that reach over their edge, and are cut back to half of `gap` from it; half of that
    is its tolerance."""
    cut = (1.0 - 0.5 * gap) / 1.5
    curve = cg.shapes.line([0, -1, 0], [0, 1, 0])
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    edge = BodyEdge(curve, 0.5 * gap, uses, ((0.0, 1.0), (0.0, 1.0)))
    trims = [[ring(0.0, cut)], [ring(1.0 - cut, 1.0)]]
    return cg.Body(_planes(turn, (-1.0, 0.5), (-0.5, 1.0)), trims=trims, edges=[edge])
