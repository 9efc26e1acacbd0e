"""The shortest path over bodies from one point to another."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers
from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.routing.obstacles import Obstacles
from contiga.routing.path import Path, path_of
from contiga.routing.start import SKIN, first_polyline, resampled
from contiga.routing.taut import pull_tight

DEFAULT_CHORDS = 200
"""Default number of chords."""
MIN_CHORDS = 10


def route(
    body: Master | Sequence[Master],
    start: ArrayLike,
    end: ArrayLike,
    via: ArrayLike = (),
    *,
    points: int = DEFAULT_CHORDS,
) -> Path:
    """Return the locally shortest path outside `body` from `start` to `end`: a taut string.

    The string has no friction, and its length is a local minimum. The first polyline consists of
    straight lines from `start` by way of `via` to `end`; where a line is blocked, it takes the
    shortest path over a grid outside the bodies. The string is then released at `via` and pulled
    tight. So `via` chooses on which side of a body it runs, and how often around it; the string
    passes through none of these points unless the path does so by itself. Where nothing holds it on
    that side, as on the upper half of a ball with both ends below, it slides off.

    Parameters
    ----------
    body : one master or several, in one frame, closed or with the free side outside
    start, end : (3,) length, outside the bodies or on a surface
    via : (k, 3) length, outside or on a surface
    points : chords along the path, 10 at least; sharp edges get more, and so does a string that
        does not come to rest, twice and four times as many. The length is of second order in their
        spacing.

    Raises
    ------
    InputError
        A point is not three finite numbers, is inside a body, or nothing leads to it; start and
        end are the same point; `points` is no whole number of 10 or more; the string does not come
        to rest outside.

    Examples
    --------
    Over a ball, between two points level with its middle: two tangents and an arc.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> path = cg.route(ball, [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], via=[[0.0, 0.0, 1.5]])
    >>> exact = 2.0 * 3.0**0.5 + np.pi / 3.0
    >>> abs(path.length - exact) < 1e-4, len(path.wraps)
    (True, 1)
    """
    obstacles = Obstacles(list(body) if isinstance(body, Sequence) else [body])
    stops = _checked_stops(obstacles, start, end, via)
    if not (isinstance(points, int) and points >= MIN_CHORDS):
        raise InputError(
            "must be a whole number", where="points", found=points, allowed=f"≥ {MIN_CHORDS}"
        )
    legs = [first_polyline(obstacles, a, b) for a, b in itertools.pairwise(stops)]
    corners = np.concatenate([legs[0][:1], *(leg[1:] for leg in legs)])
    for chords in (points, 2 * points, 4 * points):
        tight = pull_tight(obstacles, resampled(corners, chords))
        if tight.at_rest:
            break
    else:
        raise InputError(
            "the string does not come to rest",
            found=f"from {stops[0].tolist()} to {stops[-1].tolist()}",
            allowed="a way without grooves, or parts to go round, narrower than a chord",
            remedy="Take more `points`, or lead it another way by `via`",
        )
    path = path_of(obstacles, tight)
    # A chord off the bodies may still pass through a part that is thinner than the spacing.
    free = np.flatnonzero((path.body[1:] < 0) & (path.body[:-1] < 0))
    starts, ends = path.points[free], path.points[free + 1]
    blocked = obstacles.blocks(starts, ends, SKIN * obstacles.size)
    if blocked.any():
        raise InputError(
            "the string cannot be brought outside: it passes through a body",
            found=starts[np.argmax(blocked)].tolist(),
            allowed="a way that is pulled tight outside",
            remedy="Lead it round by `via`, or take more `points`",
        )
    return path


def _checked_stops(
    obstacles: Obstacles, start: ArrayLike, end: ArrayLike, via: ArrayLike
) -> FloatArray:
    """Return (k, 3) start, via, end; none is deeper in a body than `SKIN` of the bodies' size.

    Raises
    ------
    InputError
        No point of three finite numbers, a point inside a body, an end that is also the start.
    """
    named: list[tuple[str, ArrayLike]] = [("start", start)]
    named += [(f"via[{i}]", value) for i, value in enumerate(np.asarray(via, dtype=object))]
    named.append(("end", end))
    points = []
    for name, value in named:
        point = as_numbers(value, name, "must be a point", "[x, y, z]")
        if point.shape != (3,) or not np.isfinite(point).all():
            raise InputError(
                "must be a point", where=name, found=value, allowed="[x, y, z], finite"
            )
        points.append(point)
    stops = np.array(points)
    if np.array_equal(stops[0], stops[-1]):
        raise InputError(
            "a path ends in another point than it starts in",
            where="end",
            found=stops[-1].tolist(),
            remedy="Of a closed loop, route two halves",
        )
    gaps, _, bodies = obstacles.clearances(stops)
    for (name, _), point, gap, body in zip(named, stops, gaps, bodies, strict=True):
        if gap < -SKIN * obstacles.size:
            raise InputError(
                f"lies {-gap:.6g} inside {obstacles.bodies[body].name}",
                where=name,
                found=point.tolist(),
                allowed="a point outside the bodies, or on a surface",
            )
    return stops
