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


def trimmed_gutter(lip=-np.pi / 6.0):
    """A hollow cylinder of radius 1 about y, cut off at the angle `lip`, and a plane from there.

    The plane leads outwards and a little down, so that the axis is on the outer side of the edge.
    """

    def at(angle, y):
        return [np.cos(angle), y, np.sin(angle)]

    flat = cg.shapes.arc(start=lip - 1.2, end=lip + 0.3)
    net = flat.control_points
    turned = np.column_stack([net[:, 0], 0.0 * net[:, 0] - 1.0, net[:, 1]])
    arc = cg.NurbsCurve(2, flat.knots, turned, flat.weights)
    low, high = 0.0, 1.0
    for _ in range(60):
        cut = 0.5 * (low + high)
        x, _, z = arc.evaluate([cut])[0]
        low, high = (cut, high) if np.arctan2(z, x) < lip else (low, cut)
    way = np.array([0.95, 0.0, -0.3])
    ends = [[np.add(at(lip, y), x * way) for y in (-1.0, 1.0)] for x in (-0.5, 1.0)]
    plane = cg.shapes.bilinear(ends[0][0], ends[1][0], ends[0][1], ends[1][1])
    sheets = [cg.shapes.extruded(arc, [0.0, 2.0, 0.0]), plane]
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    curve = cg.shapes.line(at(lip, -1.0), at(lip, 1.0))
    edge = BodyEdge(curve, 1e-12, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body(sheets, trims=[[ring(0.0, cut)], [ring(1.0 / 3.0, 1.0)]], edges=[edge])
