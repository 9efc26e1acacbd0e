"""Last crossings of paths with a surface, with those that hang on rounding asked again."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contiga.records import ByteArray, FloatArray, Hit, empty_hit

# How often a path whose last crossing hangs on rounding is laid anew beside itself.
TRIES = 6
# By how many widths of the edge it meets, more with every try.
ASIDE = 3.0
# Widths of an edge by which the halves of a detour reach beyond their common end: one at least is
# to meet an edge that lies there.
STRICT, FIRST_HALF, SECOND_HALF = (0.0, 0.0), (0.0, 2.0), (2.0, 0.0)
# The directions in which turn by this angle from try to try: the golden one never comes back.
TURN = 2.399963229728653


class Paths(NamedTuple):
    """Straight paths of n points, or parts of them."""

    start: FloatArray
    """(n, 3) in the frame of the surface, length."""
    end: FloatArray
    """(n, 3) in the frame of the surface, length."""
    between: FloatArray
    """(n, 2) shares of the whole path at the start and at the end."""
    loose: tuple[float, float]
    """Widths of an edge by which a crossing at that edge may lie beyond the start and the end."""


Crossings = Callable[[Paths, Hit, FloatArray], None]
"""Function that writes the last crossing of each path into a `Hit`, and into (n, 2) numbers its
sense, 1 for an entry, −1 for an exit, 0 for none, and the width within which rounding decides."""


def settled(search: Crossings, a_B: FloatArray, b_B: FloatArray) -> tuple[Hit, ByteArray]:
    """Last crossings of a_B → b_B by `search`, with those that hang on rounding asked again.

    A path that meets an edge or a corner within its width, or goes in and out in one place, may
    find faces there that it does not pass, or miss one. Such a path makes a detour between the
    same ends, a few widths beside the place, in one direction after the other, until its last
    crossing is clear of all edges: whether it is in or out at its end does not depend on the way.
    Where none is, or the path is hardly longer than the width, of two crossings in one place the
    later one stands.
    """
    n = len(a_B)
    out, verdict = empty_hit(n), np.zeros((n, 2))
    search(Paths(a_B, b_B, _between(np.zeros(n), np.ones(n)), STRICT), out, verdict)
    # A path that ends within the width keeps its own answer: beside itself it is another path.
    length = np.linalg.norm(b_B - a_B, axis=1)
    rows = np.flatnonzero((verdict[:, 1] > 0.0) & (2.0 * ASIDE * verdict[:, 1] < length))
    aside, at = verdict[rows, 1], out.fraction[rows]
    for k in range(TRIES):
        if len(rows) == 0:
            break
        a, b = a_B[rows], b_B[rows]
        offset = ASIDE * (1.0 + 0.5 * k) * aside[:, None] * _across(b - a, k * TURN)
        again, anew = _by_way_of(search, a, a + at[:, None] * (b - a) + offset, b, at)
        clear = anew[:, 1] == 0.0
        for name in Hit._fields:
            getattr(out, name)[rows[clear]] = getattr(again, name)[clear]
        verdict[rows[clear]] = anew[clear]
        aside, at = np.maximum(aside, anew[:, 1])[~clear], at[~clear]
        rows = rows[~clear]
    return out, verdict[:, 0].astype(np.int8)


def _by_way_of(
    search: Crossings, a_B: FloatArray, m_B: FloatArray, b_B: FloatArray, at: FloatArray
) -> tuple[Hit, FloatArray]:
    """Last crossings of the ways a_B → m_B → b_B, whose middles stand for the fractions `at`."""
    n = len(at)
    out, verdict = empty_hit(n), np.zeros((n, 2))
    search(Paths(m_B, b_B, _between(at, np.ones(n)), SECOND_HALF), out, verdict)
    out.fraction[:] = at + (1.0 - at) * out.fraction
    rows = np.flatnonzero(verdict[:, 0] == 0.0)
    first, before = empty_hit(len(rows)), np.zeros((len(rows), 2))
    shares = _between(np.zeros(len(rows)), at[rows])
    search(Paths(a_B[rows], m_B[rows], shares, FIRST_HALF), first, before)
    first.fraction[:] *= at[rows]
    for name in Hit._fields:
        getattr(out, name)[rows] = getattr(first, name)
    verdict[rows] = before
    return out, verdict


def _between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return (n, 2), C-ordered: kernels that are called straight check no layout."""
    return np.stack([start, end], axis=1)


def _across(d: FloatArray, angle: float) -> FloatArray:
    """Unit vectors square to the rows of `d`, turned about them by `angle`."""
    d = d / np.abs(d).max(axis=1, keepdims=True)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(d).argmin(axis=1)]
    e = np.cross(d, least)
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    return np.asarray(np.cos(angle) * e + np.sin(angle) * np.cross(d, e))
