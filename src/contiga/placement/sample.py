"""Points on a part, and places on a surface where something is least."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.records import FloatArray, IntArray
from contiga.slaves.slave import Slave, box_of

SPACING = 0.04
"""Distance of the points of a sample, in parts of a body's size, at most."""
_CHORD = 1e-3
"""Tolerance of the triangles that are sampled, in parts of a body's size."""
_FINEST = 3e-7
"""Step, in parts of the size, below which a least value no longer falls by 1e-12 of it."""
_MAX_ROUNDS = 400
_STAR = np.concatenate([np.eye(3), -np.eye(3)])
"""Ways of which some lead downward in whatever tangent plane."""
_WORTH = 1e-2
_HOPELESS = 4.0
"""Steps: a start whose value is above the least by more is given up."""


def points_of(part: Master | Slave) -> FloatArray:
    """Return (n, 3) points that stand for a part: the active points of a slave, a sample of a body.

    Raises
    ------
    InputError
        No point of the slave is active.
    """
    if not isinstance(part, Slave):
        return sample(part)
    if not part.active.any():
        raise InputError("no point of it is active: nothing to measure from", where=part.name)
    return np.ascontiguousarray(part.points[part.active])


def sample(body: Master) -> FloatArray:
    """Return points (n, 3) on a body, of which no place is farther than `SPACING` of its size."""
    mesh = body.tessellate(_CHORD * body.size)
    points = _divided(mesh.vertices, mesh.triangles, SPACING * body.size)
    return np.ascontiguousarray(body.project(points).point)


def _divided(points: FloatArray, triangles: IntArray, longest: float) -> FloatArray:
    """Corners of the triangles once all sides longer than `longest` are halved."""
    corners = points[triangles]
    kept = []
    while len(corners):
        steps = np.roll(corners, -1, axis=1) - corners
        sides = np.sqrt(np.square(steps).sum(axis=2))
        long = sides.max(axis=1) > longest
        kept.append(corners[~long].reshape(-1, 3))
        corners, side = corners[long], sides[long].argmax(axis=1)
        rows = np.arange(len(corners))
        a, b = corners[rows, side], corners[rows, (side + 1) % 3]
        middle, c = 0.5 * (a + b), corners[rows, (side + 2) % 3]
        corners = np.concatenate(
            [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        )
    return np.unique(np.concatenate(kept), axis=0)


def sharpened(
    body: Master, points: FloatArray, value: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Points of a body near `points` (k, 3) of it, at which `value` is least to about 1e-12.

    A pattern search (Hooke and Jeeves, 1961) whose steps are brought back onto the surface by
    projection, so that trims, edges and corners bound it as they bound the body. Points that turn
    out not to lead to the least of all are left where they are.

    Parameters
    ----------
    body : the body
    points : (k, 3) points of it
    value : length, of points (n, 3) on the body, (n,); changes by no more than the way between two
    """
    step = np.full(len(points), 0.5 * SPACING * body.size)
    best, least = points.copy(), value(points)
    for _ in range(_MAX_ROUNDS):
        hopeful = least - least.min() <= _HOPELESS * step
        rows = np.flatnonzero(hopeful & (step > _FINEST * body.size))
        if len(rows) == 0:
            break
        tried = best[rows, None] + step[rows, None, None] * _STAR
        feet = body.project(tried.reshape(-1, 3)).point
        values = value(feet).reshape(len(rows), -1)
        choice = values.argmin(axis=1)
        lower = values[np.arange(len(rows)), choice]
        # Less than a step is worth near a place that is least is rounding, or not worth its while.
        better = lower < least[rows] - _WORTH * step[rows] ** 2 / body.size
        won = rows[better]
        best[won] = feet.reshape(len(rows), -1, 3)[better, choice[better]]
        least[won] = lower[better]
        step[rows[~better]] *= 0.5
    return best


def extent(part: Master | Slave) -> FloatArray:
    """Return the lowest and highest x, y and z (2, 3) of a part; of a slave's active points.

    Raises
    ------
    InputError
        No point of the slave is active.

    Examples
    --------
    >>> from contiga.geometry import shapes
    >>> from contiga.masters.body import Body
    >>> extent(Body(shapes.torus(major=3.0, minor=1.0))).round(9).tolist()
    [[-4.0, -4.0, -1.0], [4.0, 4.0, 1.0]]
    """
    return box_of(points_of(part)) if isinstance(part, Slave) else part.bounds()


def extent_at(body: Master, pose: FloatArray) -> FloatArray:
    """Return the lowest and highest x, y and z (2, 3) of a body at `pose` (4, 4).

    >>> from contiga.geometry import shapes
    >>> from contiga.masters.body import Body
    >>> from contiga.rigid import transform
    >>> rod = Body(shapes.cylinder(radius=1.0, height=8.0))
    >>> extent_at(rod, transform.rotation([1.0, 0.0, 0.0], np.pi / 2)).round(9).tolist()
    [[-1.0, -4.0, -1.0], [1.0, 4.0, 1.0]]
    """
    return body.transformed(pose).bounds()
