"""Profiles of lines and arcs that solids are extruded from."""

from __future__ import annotations

import math

import numpy as np
from tests.stress.fields import Piece, norm2


def at(radius: float, angle: float) -> np.ndarray:
    """A point of a circle about the origin."""
    return radius * np.array([math.cos(angle), math.sin(angle)])


def circle(centre: tuple[float, float], radius: float) -> list[Piece]:
    """A whole circle as two arcs."""
    c = np.asarray(centre)
    across = np.array([radius, 0.0])
    right, left = c + across, c - across
    return [Piece(right, left, c), Piece(left, right, c)]


def stadium(start: float, end: float, radius: float) -> list[Piece]:
    """A round-ended slot along x, from centre to centre."""
    corners = [(start, -radius), (end, -radius), (end, radius), (start, radius)]
    centres = [None, (end, 0.0), None, (start, 0.0)]
    ends = corners[1:] + corners[:1]
    return [Piece(a, b, c) for a, b, c in zip(corners, ends, centres, strict=True)]


def teeth(count: int, root: float, tip: float, share: float = 0.45) -> list[Piece]:
    """A ring of teeth: arcs on the radii `root` and `tip`, joined by straight flanks.

    A tooth's tip takes `share` of half its pitch, a root as much; the flanks lie between them.
    With tip > root the teeth point outward, with tip < root they are those of an internal gear.
    """
    pitch = 2.0 * math.pi / count
    width, flank = share * pitch, (0.5 - share) * pitch
    loop = []
    for k in range(count):
        t = k * pitch
        marks = [t, t + width, t + width + flank, t + 2.0 * width + flank]
        a, b = at(root, marks[0]), at(root, marks[1])
        c, d = at(tip, marks[2]), at(tip, marks[3])
        loop += [Piece(a, b, (0.0, 0.0)), Piece(b, c), Piece(c, d, (0.0, 0.0))]
        loop.append(Piece(d, at(root, t + pitch if k < count - 1 else 0.0)))
    return loop


def blade(inner: float, outer: float, bulge: float) -> list[Piece]:
    """A blade along +x from `inner` to `outer`: two arcs that meet in sharp edges.

    `bulge` is the greatest distance of either arc from the chord.
    """
    half = 0.5 * (outer - inner)
    radius = (half**2 + bulge**2) / (2.0 * bulge)
    middle = 0.5 * (inner + outer)
    below, above = (middle, bulge - radius), (middle, radius - bulge)
    a, b = (inner, 0.0), (outer, 0.0)
    return [Piece(b, a, below), Piece(a, b, above)]


def rod(length: float, eyes: tuple[float, float], waist: float, fillet: float) -> list[Piece]:
    """Two eyes about (0, 0) and (length, 0) and a straight bar between them, joints rounded.

    `waist` is half the width of the bar, `fillet` the radius of the hollow arcs at the eyes.
    """
    tangent = []
    for radius in eyes:
        across = waist + fillet
        tangent.append(math.sqrt((radius + fillet) ** 2 - across**2))
    left, right = np.array([0.0, 0.0]), np.array([length, 0.0])
    centre_l = np.array([tangent[0], waist + fillet])
    centre_r = np.array([length - tangent[1], waist + fillet])
    down = np.array([1.0, -1.0])
    a = left + eyes[0] / (eyes[0] + fillet) * (centre_l - left)
    b, c = centre_l - [0.0, fillet], centre_r - [0.0, fillet]
    d = right + eyes[1] / (eyes[1] + fillet) * (centre_r - right)
    assert norm2(d - right) <= eyes[1] * (1.0 + 1e-12)
    return [
        Piece(d * down, d, right),
        Piece(d, c, centre_r, turns_left=False),
        Piece(c, b),
        Piece(b, a, centre_l, turns_left=False),
        Piece(a, a * down, left),
        Piece(a * down, b * down, centre_l * down, turns_left=False),
        Piece(b * down, c * down),
        Piece(c * down, d * down, centre_r * down, turns_left=False),
    ]
