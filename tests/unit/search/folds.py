"""A fold of two trimmed faces, whose feet are known."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.geometry.edges import BodyEdge, EdgeUse


def ring(low, high):
    corners = [[low, 0, 0], [high, 0, 0], [high, 1, 0], [low, 1, 0]]
    return [cg.shapes.line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def trimmed_fold(turn, gap=0.0):
    """Two planes that meet along y at x = z = 0, bent down by `turn`, and reach over their edge.

    Both are cut back to half of `gap` from it; half of that is its tolerance.
    """
    c, s = np.cos(0.5 * turn), np.sin(0.5 * turn)

    def left(x):
        return [[x * c, y, x * s] for y in (-1.0, 1.0)]

    def right(x):
        return [[x * c, y, -x * s] for y in (-1.0, 1.0)]

    sheets = [
        cg.shapes.bilinear(a[0], b[0], a[1], b[1])
        for a, b in ((left(-1.0), left(0.5)), (right(-0.5), right(1.0)))
    ]
    cut = (1.0 - 0.5 * gap) / 1.5
    curve = cg.shapes.line([0, -1, 0], [0, 1, 0])
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    edge = BodyEdge(curve, 0.5 * gap, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body(sheets, trims=[[ring(0.0, cut)], [ring(1.0 - cut, 1.0)]], edges=[edge])
