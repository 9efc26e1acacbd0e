"""Last crossings of paths with a surface, robust against rounding by repeated searches."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contiga.records import ByteArray, FloatArray, Hit, empty_hit

# Largest number of bent paths tried for a path whose last crossing depends on rounding.
MAX_TRIES = 6
# Offset of the first detour, in widths of the edge that it meets; it grows with every try.
DETOUR_WIDTHS = 3.0
# Widths of an edge by which the halves of a detour extend beyond their common end, so that at least
# one of them meets an edge there.
NO_OVERLAP, FIRST_HALF, SECOND_HALF = (0.0, 0.0), (0.0, 2.0), (2.0, 0.0)
# Angle between the directions of successive bent paths: multiples of the golden angle never repeat.
GOLDEN_ANGLE = 2.399963229728653


class Paths(NamedTuple):
    """Straight paths of n points, or parts of them."""

    start: FloatArray
    """(n, 3) in the frame of the surface, length."""
    end: FloatArray
    """(n, 3) in the frame of the surface, length."""
    between: FloatArray
    """(n, 2) fractions of the complete path at the start and at the end."""
    loose: tuple[float, float]
    """Widths of an edge by which a crossing at that edge may lie beyond the start and the end."""


Crossings = Callable[[Paths, Hit, FloatArray], None]
"""Function that writes the last crossing of each path into a `Hit`, and into (n, 2) numbers its
sense, 1 for an entry, −1 for an exit, 0 for none, and the width within which rounding decides."""


def robust_last_crossings(
    search: Crossings, a_B: FloatArray, b_B: FloatArray
) -> tuple[Hit, ByteArray]:
    """Return the last crossings of a_B → b_B by `search`, robust against rounding.

    A path that meets an edge or a corner within its width, or enters and leaves in one place, may
    find faces there that it does not cross, or miss one. Such a path makes a detour between the
    same ends, a few widths off the place, in one direction after another, until its last crossing
    is clear of all edges: whether its end is inside does not depend on the path. The crossing of
    the perturbed path then replaces that of the path. If none of `MAX_TRIES` perturbed paths is
    clear, or the path is shorter than six widths, the result of the straight path stays.

    Parameters
    ----------
    search : see `Crossings`
    a_B, b_B : (n, 3) starts and ends, the surface's frame, length

    Returns
    -------
    hits : (n,) crossings; the fraction is of the path a_B → b_B
    sense : (n,) int8, 1 for an entry, −1 for an exit, 0 for none
    """
    n = len(a_B)
    out, verdict = empty_hit(n), np.zeros((n, 2))
    search(Paths(a_B, b_B, _between(np.zeros(n), np.ones(n)), NO_OVERLAP), out, verdict)
    # A path that ends within the width keeps its result: a detour would be a different path.
    length = np.linalg.norm(b_B - a_B, axis=1)
    rows = np.flatnonzero((verdict[:, 1] > 0.0) & (2.0 * DETOUR_WIDTHS * verdict[:, 1] < length))
    width, fraction = verdict[rows, 1], out.fraction[rows]
    for k in range(MAX_TRIES):
        if len(rows) == 0:
            break
        a, b = a_B[rows], b_B[rows]
        offset = (
            DETOUR_WIDTHS
            * (1.0 + 0.5 * k)
            * width[:, None]
            * _perpendicular(b - a, k * GOLDEN_ANGLE)
        )
        detour, new_verdict = _last_crossings_around(
            search, a, a + fraction[:, None] * (b - a) + offset, b, fraction
        )
        is_clear = new_verdict[:, 1] == 0.0
        for name in Hit._fields:
            getattr(out, name)[rows[is_clear]] = getattr(detour, name)[is_clear]
        verdict[rows[is_clear]] = new_verdict[is_clear]
        width, fraction = np.maximum(width, new_verdict[:, 1])[~is_clear], fraction[~is_clear]
        rows = rows[~is_clear]
    return out, verdict[:, 0].astype(np.int8)


def _last_crossings_around(
    search: Crossings, a_B: FloatArray, m_B: FloatArray, b_B: FloatArray, fraction: FloatArray
) -> tuple[Hit, FloatArray]:
    """Return the last crossings of the bent paths a_B → m_B → b_B, and their verdicts (n, 2).

    A verdict is the sense and the width that `Crossings` writes. The second half counts if it has a
    crossing, else the first half. m_B counts as the point at `fraction` of the path.
    """
    n = len(fraction)
    out, verdict = empty_hit(n), np.zeros((n, 2))
    search(Paths(m_B, b_B, _between(fraction, np.ones(n)), SECOND_HALF), out, verdict)
    out.fraction[:] = fraction + (1.0 - fraction) * out.fraction
    rows = np.flatnonzero(verdict[:, 0] == 0.0)
    first, first_verdict = empty_hit(len(rows)), np.zeros((len(rows), 2))
    between = _between(np.zeros(len(rows)), fraction[rows])
    search(Paths(a_B[rows], m_B[rows], between, FIRST_HALF), first, first_verdict)
    first.fraction[:] *= fraction[rows]
    for name in Hit._fields:
        getattr(out, name)[rows] = getattr(first, name)
    verdict[rows] = first_verdict
    return out, verdict


def _between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return starts and ends as (n, 2), C-ordered: kernels called directly do not check layouts."""
    return np.stack([start, end], axis=1)


def _perpendicular(d: FloatArray, angle: float) -> FloatArray:
    """Return unit vectors perpendicular to the rows of `d`, turned about these by `angle`, radians.

    At the angle zero they are also perpendicular to the axis that `d` is least along.
    """
    d = d / np.abs(d).max(axis=1, keepdims=True)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    smallest_axis = np.eye(3)[np.abs(d).argmin(axis=1)]
    e = np.cross(d, smallest_axis)
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    return np.asarray(np.cos(angle) * e + np.sin(angle) * np.cross(d, e))
