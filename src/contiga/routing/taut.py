"""Pull a string tight over obstacles.

The string is a polyline x_0 … x_n with fixed ends. It minimises ½ Σ |x_{i+1} − x_i|²/w_i, whose
minima with intervals w_i = |x_{i+1} − x_i| are those of the length, subject to gap(x_i) ≥ r. An
augmented Lagrangian with an active set solves that: each step is one banded system with the
curvature λ ∇²gap of the surfaces in it, so that it converges as Newton's method does; where the
matrix is not positive definite, as on the way to a minimum, the curvature is left out.

On smooth bodies r = 0, and chords cut into a body by h²κ/8, so that the length is of second order
in the spacing. Sharp edges lie between two points wherever these are, and a chord would cut them
off. There r goes down from the spacing to `SHARP` of the length: the surface at a distance r is
smooth, and points are added where a chord still cuts.
"""

from __future__ import annotations

from math import ceil, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbsv

from contiga.records import FloatArray
from contiga.routing.obstacles import Obstacles

TURN = 0.15
"""Radians that the string may turn by within a chord at an edge."""
SHARP = 1e-6
"""Radius that sharp edges are rounded by at the end, as a share of the length."""
SHRINK = 0.25
"""Factor on that radius from one level to the next."""
PENALTY = 1e4
"""Stiffness of an active constraint over that of the two chords beside it."""
MAX_SETS = 50
"""Largest number of active sets in a step over sharp edges, where none may be right; elsewhere it
is the number of points."""
STEPS, EARLY_STEPS = 100, 20
"""Relaxation steps at the last radius of edges, or without edges, and at earlier radii."""
SETTLED, SETTLED_AT_EDGES = 1e-11, 1e-2
"""Largest move of a string at rest, as a share of its length and of the radius of edges."""
CHANGE = 1e-5
"""Largest final change of a string's length over sharp edges, and largest length that its chords
cut off, as shares of the length: points next to an edge may alternate across it without end."""
BENDING = 1.0, 0.9, 0.0
"""Shares of the curvature that a step is tried with: the second for strings that may lie on either
side, as over a ball through its middle, to which curvature leaves no stiffness sideways."""
DIVISIONS, EARLY_DIVISIONS = 8, 3
"""Divisions of chords at the last radius, and at earlier radii."""
FIRST_RADIUS = 0.25
"""Largest radius of edges, as a share of the spacing: a larger one does not fit into grooves and
holes, and points alternate across it."""
PIECES = 8
"""Parts that a chord which cuts off an edge is split into."""


class Tight(NamedTuple):
    """A string at rest."""

    points: FloatArray
    """(n, 3)."""
    rounding: float
    """Distance that it keeps from surfaces, length; 0 where no edge is sharp."""
    at_rest: bool
    """Whether it has come to rest, and no chord cuts off an edge."""


class _Constraints(NamedTuple):
    """Constraints that keep interior points outside, one row a pair of a point and a body."""

    point: NDArray[np.intp]
    gap: FloatArray
    normal: FloatArray
    bending: FloatArray


def pull_tight(obstacles: Obstacles, points: FloatArray) -> Tight:
    """Relax a polyline (n + 1, 3) of even spacing to a taut string."""
    length = _length(points)
    spacing = length / (len(points) - 1)
    points, at_rest = _relaxed(obstacles, points, 0.0, _even(points))
    if len(_cutting(obstacles, points, 0.0).chords) == 0:
        return Tight(points, 0.0, at_rest)
    first = FIRST_RADIUS * spacing
    levels = ceil(log(first / (SHARP * length), 1.0 / SHRINK)) + 1
    radii = np.geomspace(first, SHARP * length, levels)
    for i, radius in enumerate(radii):
        if i > 0:
            points = _shrunk(obstacles, _thinned(points, spacing), radii[i - 1], radius)
        is_last = i == len(radii) - 1
        for _ in range(DIVISIONS if is_last else EARLY_DIVISIONS):
            before = _length(points)
            steps = STEPS if is_last else EARLY_STEPS
            points, at_rest = _relaxed(obstacles, points, radius, _chords(points), steps)
            at_rest |= abs(_length(points) - before) <= CHANGE * length
            cutting = _cutting(obstacles, points, radius)
            if len(cutting.chords) == 0 or (
                is_last and at_rest and cutting.shortened <= CHANGE * length
            ):
                break
            points = _divided(points, cutting.chords, radius)
    return Tight(points, SHARP * length, at_rest and cutting.shortened <= CHANGE * length)


def _shrunk(obstacles: Obstacles, points: FloatArray, radius: float, smaller: float) -> FloatArray:
    """The polyline with what lies at a distance `radius` moved to a `smaller` one.

    Arcs about edges keep their points, and shrink.
    """
    near = obstacles.clearances(points)
    lies = near.gap < 1.001 * radius
    lies[[0, -1]] = False
    return np.where(lies[:, None], points - (near.gap - smaller)[:, None] * near.normal, points)


def _even(points: FloatArray) -> FloatArray:
    """Intervals of a string whose points are to be evenly spaced."""
    return np.full(len(points) - 1, _length(points) / (len(points) - 1))


def _divided(points: FloatArray, chords: NDArray[np.intp], radius: float) -> FloatArray:
    """Return the polyline with chords cut into pieces that turn by `TURN` at an edge of a `radius`.

    There are at most `PIECES` of them.
    """
    pieces = np.ones(len(points) - 1, dtype=int)
    lengths = np.linalg.norm(points[chords + 1] - points[chords], axis=1)
    pieces[chords] = np.clip(np.ceil(lengths / (TURN * radius)), 2, PIECES)
    arc = np.concatenate([[0], np.cumsum(pieces)])
    at = np.arange(arc[-1] + 1)
    return np.stack([np.interp(at, arc, x) for x in points.T], axis=1)


def _length(points: FloatArray) -> float:
    return float(_chords(points).sum())


def _chords(points: FloatArray) -> FloatArray:
    """Return (n − 1,) lengths of the chords."""
    return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1))


class _Cutting(NamedTuple):
    """Chords that cut off an edge."""

    chords: NDArray[np.intp]
    """(k,) numbers of the chords."""
    shortened: float
    """Length that the chords save against the paths around these edges."""


def _cutting(obstacles: Obstacles, points: FloatArray, radius: float) -> _Cutting:
    """Chords whose middles are deeper than those of an arc that turns by `TURN`."""
    chords = _chords(points)
    middles = 0.5 * (points[1:] + points[:-1])
    depth = radius - obstacles.clearances(middles).gap
    # Ends may lie on a surface: the first and last chord come off it.
    depth[[0, -1]] -= radius
    cut = np.flatnonzero(depth > TURN / 8.0 * chords)
    around = 2.0 * np.hypot(0.5 * chords[cut], depth[cut])  # two sides of a triangle on the chord
    return _Cutting(cut, float((around - chords[cut]).sum()))


def _thinned(points: FloatArray, spacing: float) -> FloatArray:
    """Return a path without points between chords that are together straight and short.

    Short is no longer than `spacing`.
    """
    keep = np.ones(len(points), dtype=bool)
    last = 0
    for i in range(1, len(points) - 1):
        before, after = points[i] - points[last], points[i + 1] - points[i]
        a, b = float(np.linalg.norm(before)), float(np.linalg.norm(after))
        straight = float(np.linalg.norm(np.cross(before, after))) < 0.1 * TURN * a * b
        if straight and a + b <= spacing:
            keep[i] = False
        else:
            last = i
    return points[keep]


def _relaxed(
    obstacles: Obstacles,
    points: FloatArray,
    radius: float,
    intervals: FloatArray,
    steps: int = STEPS,
) -> tuple[FloatArray, bool]:
    """The string at rest at a distance `radius`, and whether it is.

    Its points slide along it until their chords are as `intervals` (n,).
    """
    x = points.copy()
    bodies, inner = len(obstacles.bodies), len(x) - 2
    multiplier = np.zeros(bodies * inner)
    length = float(intervals.sum())
    room = 2.0 * np.minimum(intervals[1:], intervals[:-1])
    settled = SETTLED_AT_EDGES * radius if radius > 0.0 else SETTLED * length
    k = 1.0 / np.maximum(intervals, 1e-3 * SHARP * length)
    for _ in range(steps):
        pull = np.diff(x, axis=0) * k[:, None]
        outside = _constraints(obstacles, x[1:-1])
        move, multiplier = _step(k, pull[1:] - pull[:-1], outside, radius, multiplier)
        # No farther than what is known to be free, and a little.
        free = np.abs(outside.gap.reshape(bodies, inner)).min(axis=0) + room
        size = np.linalg.norm(move, axis=1)
        move *= np.minimum(1.0, free / np.maximum(size, 1e-300))[:, None]
        x[1:-1] += move
        if size.max(initial=0.0) <= settled:
            return x, True
    return x, False


def _constraints(obstacles: Obstacles, points: FloatArray) -> _Constraints:
    points = np.ascontiguousarray(points)
    feet = obstacles.feet(points)
    return _Constraints(
        np.tile(np.arange(len(points)), len(feet)),
        np.concatenate([one.gap for one in feet]),
        np.concatenate([one.normal for one in feet]),
        np.concatenate([obstacles.bending(points, one, i) for i, one in enumerate(feet)]),
    )


def _step(
    k: FloatArray, force: FloatArray, outside: _Constraints, radius: float, multiplier: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Moves (n, 3) of interior points and the new multipliers of their constraints."""
    both = k[:-1] + k[1:]
    stiff = PENALTY * both[outside.point]
    slack = outside.gap - radius
    bent = multiplier[:, None, None] * outside.bending
    plain = both[:, None, None] * np.eye(3)
    normal = outside.normal
    normals = stiff[:, None, None] * normal[:, :, None] * normal[:, None, :]
    pushed = normal * (multiplier - stiff * slack)[:, None]
    active = multiplier - stiff * slack > 0.0
    move, pressed = np.zeros_like(force), multiplier
    for share in BENDING:
        tried: set[bytes] = set()
        # The string lifts off a chord at a time.
        max_sets = MAX_SETS if radius > 0.0 else len(active)
        while active.tobytes() not in tried and len(tried) < max_sets:
            tried.add(active.tobytes())
            rows = np.flatnonzero(active)
            at = outside.point[rows]
            blocks, right = plain.copy(), force.copy()
            np.add.at(blocks, at, normals[rows] - share * bent[rows])
            np.add.at(right, at, pushed[rows])
            solved = _solved(blocks, k[1:-1], right)
            if solved is None:
                break
            move = solved
            pressed = multiplier - stiff * (slack + (normal * move[outside.point]).sum(axis=1))
            active = pressed > 0.0
        else:
            break
    return move, np.maximum(pressed, 0.0)


def _solved(blocks: FloatArray, k: FloatArray, right: FloatArray) -> FloatArray | None:
    """Solve the block tridiagonal system with 3 × 3 blocks and −k beside the diagonal.

    Returns None if the matrix is not positive definite.
    """
    n = len(blocks)
    bands = np.zeros((4, n, 3))
    bands[0, 1:] = -k[:, None]
    bands[3] = blocks[:, range(3), range(3)]
    bands[2, :, 1], bands[2, :, 2] = blocks[:, 0, 1], blocks[:, 1, 2]
    bands[1, :, 2] = blocks[:, 0, 2]
    _, solution, info = dpbsv(bands.reshape(4, -1), right.reshape(-1))
    return solution.reshape(-1, 3) if info == 0 else None
