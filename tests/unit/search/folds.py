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


def axes_of(turn, k):
    """Of sheet k of a fold: the way in which x runs, and up."""
    lean = 0.5 * turn * (1.0 if k == 0 else -1.0)
    return (
        np.array([np.cos(lean), 0.0, np.sin(lean)]),
        np.array([-np.sin(lean), 0.0, np.cos(lean)]),
    )


def place(turn, k, x, z):
    """In the axes of a sheet of a fold, over its middle."""
    into, out = axes_of(turn, k)
    return x * into + z * out


def over(turn, bend, c, x, high):
    """A point so high over z = bend (x² − 2 c x) at x, on the left sheet."""
    normal = np.array([-2.0 * bend * (x - c), 1.0])
    normal *= high / np.linalg.norm(normal)
    return place(turn, 0, x + normal[0], bend * (x * x - 2.0 * c * x) + normal[1])


def focal(bend, past=4e-4):
    """Height `past` beyond the focal point of z = bend x², and how far the two minima of f lie to
    each side then."""
    return 0.5 * (1.0 + past) / bend, np.sqrt(0.5 * past) / bend


def sheet(turn, k, ends, bow, sway, bulge, middle, twist, tilt):
    """Sheet k of `bent_fold`, over the range `ends` of x."""
    low, high = ends
    into, out = axes_of(turn, k)
    net = np.empty((3, 3, 3))
    across = ((low, low**2), (0.5 * (low + high), low * high), (high, high**2))
    for i, (x, xx) in enumerate(across):
        for j, (y, yy) in enumerate(((-1.0, 1.0), (0.0, -1.0), (1.0, 1.0))):
            up = bulge * (xx - 2.0 * middle * x) + twist * x * y + k * tilt * y
            net[i, j] = x * into + up * out + [sway * yy, y, bow * yy]
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    return cg.NurbsSurface((2, 2), (knots, knots), net)


def bent_fold(
    turn,
    bow=0.0,
    sway=0.0,
    bulge=(0.0, 0.0),
    twist=(0.0, 0.0),
    middle=(0.0, 0.0),
    far=1.0,
    tilt=0.0,
):
    """Two trimmed sheets that meet along C(y) = (sway y², y, bow y²), bent down by `turn`.

    x away from the edge (x < 0 on the left one, k = 0) each is bulge (x² − 2 middle x) + twist x y
    higher, along the second of `axes_of`; y runs from −1 to 1, and each reaches 0.5 over the edge.
    The right one is trimmed away `far` from it, too, and is `tilt` y higher than would fit.
    """
    sheets = [
        sheet(turn, k, ends, bow, sway, bulge[k], middle[k], twist[k], tilt)
        for k, ends in enumerate(((-1.0, 0.5), (-0.5, 1.0)))
    ]
    points = [[sway, -1.0, bow], [-sway, 0.0, -bow], [sway, 1.0, bow]]
    curve = cg.NurbsCurve(2, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0], points)
    uses = (EdgeUse(0, 0, 1, False), EdgeUse(1, 0, 3, True))
    edge = BodyEdge(curve, abs(tilt), uses, ((0.0, 1.0), (0.0, 1.0)))
    loops = [[ring(0.0, 1.0 / 1.5)], [ring(0.5 / 1.5, (0.5 + far) / 1.5)]]
    return cg.Body(sheets, trims=loops, edges=[edge])


def at_fold(body, k, x, y):
    """Where sheet k of a fold of one element each is, x from its edge and y along it: (e, s, t)."""
    low = (-1.0, -0.5)[k]
    return k, (x - low) / 1.5 - 0.5, 0.5 * y


def natural_fold(turn, bow=0.0, bulge=(0.0, 0.0), middle=(0.0, 0.0), wide=1.0):
    """The sheets of `bent_fold` without what reaches over, untrimmed: they meet in a crease. x runs
    along v. The left one is as wide as said."""
    return cg.Body(
        [
            sheet(turn, k, ends, bow, 0.0, bulge[k], middle[k], 0.0, 0.0).transposed()
            for k, ends in enumerate(((-wide, 0.0), (0.0, 1.0)))
        ]
    )


def at_crease(body, k, x, y):
    """As `at_fold`, for a natural fold."""
    return k, 0.5 * y, x + (0.5 if k == 0 else -0.5)


def plates_along_parabola(bend):
    """Two halves of a flat square with corners at ±1 that meet along x = bend y², |y| ≤ 0.2."""
    x = 0.04 * bend
    plate = cg.shapes.bilinear([-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0])
    at = np.array([[x, -0.2, 0.0], [-x, 0.0, 0.0], [x, 0.2, 0.0]])
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    inside = 0.5 * at + np.array([0.5, 0.5, 0.0])
    loops = []
    for low, points in ((0.0, inside), (1.0, inside[::-1])):
        end = 1.0 if low == 0.0 else 0.0
        u = points[0, 0]
        corners = [points[2], [u, end, 0], [low, end, 0], [low, 1 - end, 0], [u, 1 - end, 0]]
        ways = zip(corners, [*corners[1:], points[0]], strict=True)
        loops.append([[cg.NurbsCurve(2, knots, points), *(cg.shapes.line(*way) for way in ways)]])
    uses = (EdgeUse(0, 0, 0, False), EdgeUse(1, 0, 0, True))
    edge = BodyEdge(cg.NurbsCurve(2, knots, at), 1e-9, uses, ((0.0, 1.0), (0.0, 1.0)))
    return cg.Body([plate, plate], trims=loops, edges=[edge])
