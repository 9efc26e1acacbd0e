"""Points on a part, its box, and local minima of a function on a surface."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.slaves.slave import Slave, box_of

SPACING = 0.04
"""Largest distance of the points of a sample, as a share of the body's size."""
_CHORD_TOL = 1e-3
"""Tolerance of the triangles that are sampled, as a share of the body's size."""
_MIN_STEP = 3e-7
"""Step, as a share of the size, below which the minimum no longer falls by 1e-12 of the size."""
_MAX_ROUNDS = 400
_DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3)])
"""Search directions: in any tangent plane one of them leads downward."""
_MIN_DECREASE = 1e-2
"""Least decrease that a step is accepted for, in squares of the step over the size."""
_HOPELESS_STEPS = 4.0
"""A start is abandoned if its value exceeds the minimum by more than this many steps."""


def points_of(part: Master | Slave) -> FloatArray:
    """Return a copy of the active points (n, 3) of a slave, or the `sample` of a body.

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
    """Return points (n, 3) on a body, sorted by x, y, z before they are projected onto it.

    They are the corners of its tessellation (to `_CHORD_TOL` of its size), whose triangles are
    halved until no side is longer than `SPACING` of its size.
    """
    mesh = body.tessellate(_CHORD_TOL * body.size)
    corners = mesh.vertices[mesh.triangles]
    finished = []
    # Halve triangles at their longest side until all sides are short.
    while len(corners):
        lengths = np.sqrt(np.square(np.roll(corners, -1, axis=1) - corners).sum(axis=2))
        is_long = lengths.max(axis=1) > SPACING * body.size
        finished.append(corners[~is_long].reshape(-1, 3))
        corners, side = corners[is_long], lengths[is_long].argmax(axis=1)
        rows = np.arange(len(corners))
        a, b, c = (corners[rows, (side + k) % 3] for k in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate(
            [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        )
    points = np.unique(np.concatenate(finished), axis=0)
    return np.ascontiguousarray(body.project(points).point)


def sharpened(
    body: Master, points: FloatArray, value: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Return `points` (k, 3) of a body moved to local minima of `value` on it.

    A pattern search (Hooke and Jeeves, 1961) that projects its steps back onto the surface, so that
    trims, edges and corners bound it as they bound the body. It ends at a step of `_MIN_STEP` of
    the size, where values are minimal to about 1e-12 of it, or after 400 rounds. A point whose
    value exceeds the smallest by more than four steps is abandoned: it stays where it is then.

    Parameters
    ----------
    body : the body
    points : (k, 3) points of it
    value : of points (n, 3) on the body, (n,) lengths; must be 1-Lipschitz
    """
    step = np.full(len(points), 0.5 * SPACING * body.size)
    best, minimum = points.copy(), value(points)
    for _ in range(_MAX_ROUNDS):
        is_hopeful = minimum - minimum.min() <= _HOPELESS_STEPS * step
        rows = np.flatnonzero(is_hopeful & (step > _MIN_STEP * body.size))
        if len(rows) == 0:
            break
        trials = best[rows, None] + step[rows, None, None] * _DIRECTIONS
        feet = body.project(trials.reshape(-1, 3)).point
        values = value(feet).reshape(len(rows), -1)
        choice = values.argmin(axis=1)
        lowest = values[np.arange(len(rows)), choice]
        # Near a minimum a smaller decrease is rounding, or not worth its step.
        improved = lowest < minimum[rows] - _MIN_DECREASE * step[rows] ** 2 / body.size
        moved = rows[improved]
        best[moved] = feet.reshape(len(rows), -1, 3)[improved, choice[improved]]
        minimum[moved] = lowest[improved]
        step[rows[~improved]] *= 0.5
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
