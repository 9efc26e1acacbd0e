"""Pull a string tight over obstacles.

The string is a polyline x_0 … x_n with fixed ends. It minimises ½ Σ |x_{i+1} − x_i|²/w_i, which
has the same minima as the length if the intervals are w_i = |x_{i+1} − x_i|, subject to
gap(x_i) ≥ r. The solver is an augmented Lagrangian with an active set: each step is one banded
system that includes the curvature λ ∇²gap of the surfaces, so that it converges as Newton's method
does. If the matrix is not positive definite, as it may be far from a minimum, the step leaves the
curvature out.

On smooth bodies r = 0, and chords cut into a body by h²κ/8, so that the length is of second order
in the spacing. A sharp edge always lies between two points, and a chord would cut it off. There r
shrinks from the spacing to `FINAL_RADIUS` of the length: the surface at a distance r is smooth, and
chords that still cut are divided.
"""

from __future__ import annotations

from math import ceil, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbsv

from contiga.records import FloatArray
from contiga.routing.obstacles import Obstacles

MAX_TURN = 0.15
"""Largest turn of the string within a chord at an edge, rad."""
FINAL_RADIUS = 1e-6
"""Final radius that rounds sharp edges, as a share of the length."""
SHRINK = 0.25
"""Factor on that radius from one level to the next."""
PENALTY = 1e4
"""Stiffness of an active constraint, as a multiple of that of its two chords."""
MAX_SETS = 50
"""Largest number of active sets tried in a step over sharp edges, where none may be right;
elsewhere it is the number of constraints."""
MAX_STEPS, EARLY_MAX_STEPS = 100, 20
"""Largest numbers of steps at the last radius of edges, or without edges, and at earlier radii."""
REST_TOL, EDGE_REST_TOL = 1e-11, 1e-2
"""Largest move of a string at rest, as a share of its length and of the radius of edges."""
LENGTH_TOL = 1e-5
"""Largest final change of a string's length over sharp edges, and largest length that its chords
cut off, as shares of the length: points next to an edge may alternate across it without end."""
CURVATURE_SHARES = 1.0, 0.9, 0.0
"""Shares of the curvature that a step tries in turn: the second serves strings that may lie on
either side, as over the middle of a ball, where full curvature leaves no sideways stiffness."""
MAX_DIVISIONS, EARLY_MAX_DIVISIONS = 8, 3
"""Largest numbers of divisions of chords at the last radius, and at earlier radii."""
FIRST_RADIUS = 0.25
"""First radius of edges, as a share of the spacing: a larger one does not fit into grooves and
holes, and points alternate across it."""
MAX_PIECES = 8
"""Largest number of parts that a chord which cuts off an edge is split into."""


class Tight(NamedTuple):
    """A string at rest."""

    points: FloatArray
    """(n, 3)."""
    rounding: float
    """Distance of the string from surfaces, length; 0 if it passes no sharp edge."""
    at_rest: bool
    """Whether the string has come to rest and no chord cuts off an edge."""


class _Constraints(NamedTuple):
    """Constraints of interior points, one row per pair of a body and a point, body by body."""

    point: NDArray[np.intp]
    """(n,) indices of the interior points."""
    gap: FloatArray
    """(n,) signed distances from the bodies."""
    normal: FloatArray
    """(n, 3) gradients of the gaps."""
    bending: FloatArray
    """(n, 3, 3) second derivatives of the gap."""


class _EdgeCuts(NamedTuple):
    """Chords that cut off an edge."""

    chords: NDArray[np.intp]
    """(k,) indices of the chords."""
    shortened: float
    """Length that the chords save against the paths around these edges."""


def pull_tight(obstacles: Obstacles, points: FloatArray) -> Tight:
    """Return `points` (n + 1, 3), of even spacing, relaxed to a taut string with the same ends.

    It is first relaxed onto the surfaces, and keeps its points if no chord then cuts off an edge.
    Otherwise edges are rounded by radii that shrink from level to level, and the number and
    spacing of points change: points on straight parts are removed and chords
    that cut are divided, into at most `MAX_PIECES` parts that turn by about `MAX_TURN` each. At the
    last radius a string also counts as at rest if its length changes by less than `LENGTH_TOL`.
    The result is at rest only if the chords that still cut save less than that, too; its rounding
    is 0 if no edge was cut.
    """
    length = _length(points)
    spacing = length / (len(points) - 1)
    even_intervals = np.full(len(points) - 1, spacing)
    points, at_rest = _relaxed(obstacles, points, 0.0, even_intervals)
    if len(_edge_cuts(obstacles, points, 0.0).chords) == 0:
        return Tight(points, 0.0, at_rest)
    first, final = FIRST_RADIUS * spacing, FINAL_RADIUS * length
    radii = np.geomspace(first, final, ceil(log(first / final, 1.0 / SHRINK)) + 1)
    for i, radius in enumerate(radii):
        if i > 0:
            points = _without_straight_points(points, spacing)
            # Arcs about edges keep their points, and shrink to the smaller radius.
            gap, normal, _ = obstacles.clearances(points)
            on_arc = gap < 1.001 * radii[i - 1]
            on_arc[[0, -1]] = False
            points = np.where(on_arc[:, None], points - (gap - radius)[:, None] * normal, points)
        is_last = i == len(radii) - 1
        for _ in range(MAX_DIVISIONS if is_last else EARLY_MAX_DIVISIONS):
            previous_length = _length(points)
            steps = MAX_STEPS if is_last else EARLY_MAX_STEPS
            points, at_rest = _relaxed(obstacles, points, radius, _chords(points), steps)
            at_rest |= abs(_length(points) - previous_length) <= LENGTH_TOL * length
            cuts = _edge_cuts(obstacles, points, radius)
            is_accurate = cuts.shortened <= LENGTH_TOL * length
            if len(cuts.chords) == 0 or (is_last and at_rest and is_accurate):
                break
            pieces = np.ones(len(points) - 1, dtype=int)
            lengths = np.linalg.norm(points[cuts.chords + 1] - points[cuts.chords], axis=1)
            pieces[cuts.chords] = np.clip(np.ceil(lengths / (MAX_TURN * radius)), 2, MAX_PIECES)
            arc = np.concatenate([[0], np.cumsum(pieces)])
            t = np.arange(arc[-1] + 1)
            points = np.stack([np.interp(t, arc, x) for x in points.T], axis=1)
    return Tight(points, final, at_rest and is_accurate)


def _length(points: FloatArray) -> float:
    return float(_chords(points).sum())


def _chords(points: FloatArray) -> FloatArray:
    """Return (n − 1,) lengths of the chords."""
    return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1))


def _edge_cuts(obstacles: Obstacles, points: FloatArray, radius: float) -> _EdgeCuts:
    """Return chords with middles nearer than `radius` to a body, and the length that they save.

    Nearer is by more than `MAX_TURN` / 8 of the chord: the sagitta of an arc on the chord that
    turns by `MAX_TURN`. A chord at an end of the string is measured from the surface instead.
    """
    chords = _chords(points)
    middles = 0.5 * (points[1:] + points[:-1])
    depth = radius - obstacles.clearances(middles).gap
    # Ends may lie on a surface: the first and the last chord start from it.
    depth[[0, -1]] -= radius
    cut = np.flatnonzero(depth > MAX_TURN / 8.0 * chords)
    around = 2.0 * np.hypot(0.5 * chords[cut], depth[cut])  # two sides of a triangle on the chord
    return _EdgeCuts(cut, float((around - chords[cut]).sum()))


def _without_straight_points(points: FloatArray, spacing: float) -> FloatArray:
    """Return the points but for those between two chords that turn by less than 0.1 `MAX_TURN`.

    The two chords are together no longer than `spacing`. The ends stay.
    """
    is_needed = np.ones(len(points), dtype=bool)
    last = 0
    for i in range(1, len(points) - 1):
        before, after = points[i] - points[last], points[i + 1] - points[i]
        a, b = float(np.linalg.norm(before)), float(np.linalg.norm(after))
        is_straight = float(np.linalg.norm(np.cross(before, after))) < 0.1 * MAX_TURN * a * b
        if is_straight and a + b <= spacing:
            is_needed[i] = False
        else:
            last = i
    return points[is_needed]


def _relaxed(
    obstacles: Obstacles,
    points: FloatArray,
    radius: float,
    intervals: FloatArray,
    steps: int = MAX_STEPS,
) -> tuple[FloatArray, bool]:
    """Return the string relaxed to a distance `radius` from bodies, and whether it is at rest.

    It takes at most `steps` Newton steps, and is at rest if no point would move by more than
    `EDGE_REST_TOL` of the radius (`REST_TOL` of the length without one). Interior points slide
    along the string until their chords have the lengths `intervals` (n,), of which they are springs
    with the stiffness 1 / interval. `points` are not changed.
    """
    x = points.copy()
    bodies, inner = len(obstacles.bodies), len(x) - 2
    multiplier = np.zeros(bodies * inner)
    length = float(intervals.sum())
    margin = 2.0 * np.minimum(intervals[1:], intervals[:-1])
    rest_tol = EDGE_REST_TOL * radius if radius > 0.0 else REST_TOL * length
    k = 1.0 / np.maximum(intervals, 1e-3 * FINAL_RADIUS * length)
    for _ in range(steps):
        tension = np.diff(x, axis=0) * k[:, None]
        p = np.ascontiguousarray(x[1:-1])
        feet = obstacles.feet(p)
        constraints = _Constraints(
            np.tile(np.arange(inner), bodies),
            np.concatenate([foot.gap for foot in feet]),
            np.concatenate([foot.normal for foot in feet]),
            np.concatenate([obstacles.bending(p, foot, i) for i, foot in enumerate(feet)]),
        )
        force = tension[1:] - tension[:-1]
        move, multiplier = _newton_step(k, force, constraints, radius, multiplier)
        # A point moves no farther than its distance from all bodies, and a margin.
        free = np.abs(constraints.gap.reshape(bodies, inner)).min(axis=0) + margin
        size = np.linalg.norm(move, axis=1)
        move *= np.minimum(1.0, free / np.maximum(size, 1e-300))[:, None]
        x[1:-1] += move
        if size.max(initial=0.0) <= rest_tol:
            return x, True
    return x, False


def _newton_step(
    k: FloatArray,
    force: FloatArray,
    constraints: _Constraints,
    radius: float,
    multiplier: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return moves (n, 3) of interior points and the new multipliers of their constraints.

    The active set is taken from the multipliers and solved anew until one repeats, or `MAX_SETS`
    were tried. If its matrix is not positive definite, the next of `CURVATURE_SHARES` is tried; the
    last solution counts, or no move at all. Multipliers are not negative. `k` (n + 1,) is the
    stiffness of the chords, `force` (n, 3) the pull of the two chords at each point.
    """
    point, gap, normal, bending = constraints
    chord_stiffness = k[:-1] + k[1:]
    penalty = PENALTY * chord_stiffness[point]
    slack = gap - radius
    pressure = multiplier - penalty * slack
    curvature = multiplier[:, None, None] * bending
    normal_stiffness = penalty[:, None, None] * normal[:, :, None] * normal[:, None, :]
    push = normal * pressure[:, None]
    active = pressure > 0.0
    move, new_multiplier = np.zeros_like(force), multiplier
    # The string lifts off one chord at a time.
    max_sets = MAX_SETS if radius > 0.0 else len(active)
    for share in CURVATURE_SHARES:
        tried_sets: set[bytes] = set()
        while active.tobytes() not in tried_sets and len(tried_sets) < max_sets:
            tried_sets.add(active.tobytes())
            rows = np.flatnonzero(active)
            blocks = chord_stiffness[:, None, None] * np.eye(3)
            right = force.copy()
            np.add.at(blocks, point[rows], normal_stiffness[rows] - share * curvature[rows])
            np.add.at(right, point[rows], push[rows])
            solution = _solve_block_tridiagonal(blocks, k[1:-1], right)
            if solution is None:
                break
            move = solution
            new_multiplier = multiplier - penalty * (slack + (normal * move[point]).sum(axis=1))
            active = new_multiplier > 0.0
        else:
            break
    return move, np.maximum(new_multiplier, 0.0)


def _solve_block_tridiagonal(
    blocks: FloatArray, k: FloatArray, right: FloatArray
) -> FloatArray | None:
    """Solve the system with blocks (n, 3, 3) on the diagonal and −k I next to it, by Cholesky.

    Returns the solution (n, 3) for `right` (n, 3); None if the matrix is not positive definite.
    """
    bands = np.zeros((4, len(blocks), 3))
    bands[0, 1:] = -k[:, None]
    bands[3] = blocks[:, range(3), range(3)]
    bands[2, :, 1], bands[2, :, 2] = blocks[:, 0, 1], blocks[:, 1, 2]
    bands[1, :, 2] = blocks[:, 0, 2]
    _, solution, info = dpbsv(bands.reshape(4, -1), right.reshape(-1))
    return solution.reshape(-1, 3) if info == 0 else None
