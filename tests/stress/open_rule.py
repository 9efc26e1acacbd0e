"""The wall that holds a point on an open body, by brute force along its path.

A free point comes in where the last crossing of its step is from the free side. Its guard g is the
outward normal of the wall there. From then on, its depth before being d, on a piece of path of
length w:

1. The nearest place N of the shell is the foot, and its normal becomes g, if the point is behind
   it, N is not on a border, its normal is not opposite to g, and N is not nearer than d − w.
2. Else the foot is the nearest of those that have the point behind them, are not opposite to g,
   lie between d − w and d + w off, and were not nearer than d where the piece began.
3. If there is none the point has come out through its wall, or the foot has run over a border, or
   the minimum has vanished: then the nearest foot that has the point behind it and is not opposite
   takes over.

On a closed body a point is let go wherever it comes out.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from tests.stress.fields import norm
from tests.stress.shells import Entry, Feet, Shell, dot

OPPOSITE = np.cos(np.deg2rad(160.0))
"""Cosine of the angle between two normals from which on their walls are opposite."""
HALVINGS = 48


class Becomes(IntEnum):
    """What has become of a point in a step."""

    FREE = 0
    NEW = 1
    OLD = 2
    RELEASED = 3
    SLID_OFF = 4
    REACQUIRED = 9
    ENDED = 20
    """Its minimum has vanished, and no other wall holds it: the rule says nothing."""


class Held(NamedTuple):
    """Points, (n,), and what holds them."""

    on: np.ndarray
    """Whether they are in contact."""
    depth: np.ndarray
    """Zero of free points."""
    guard: np.ndarray
    """(n, 3)"""
    normal: np.ndarray
    """(n, 3) at the foot."""
    became: np.ndarray
    """`Becomes` in the last step."""


def free(n: int) -> Held:
    """n points that are not in contact."""
    guard, normal = np.zeros((2, n, 3))
    return Held(np.zeros(n, bool), np.zeros(n), guard, normal, np.zeros(n, int))


class Found(NamedTuple):
    """The feet that hold points at the end of a piece."""

    any: np.ndarray
    depth: np.ndarray
    normal: np.ndarray
    guard: np.ndarray


def _rows(feet: Feet, rows: np.ndarray) -> Feet:
    return Feet(*(column[rows] for column in feet))


def look(
    before: np.ndarray, now: Feet, depth: np.ndarray, guard: np.ndarray, w: np.ndarray
) -> Found:
    """Clauses 1 and 2, `before` (n, m) being how far the feet were where the piece began."""
    n = np.arange(len(depth))
    slack = 1e-9 * w + 1e-13
    along = np.einsum("nmk,nk->nm", now.normal, guard)
    least, most = depth - w - slack, depth + w + slack
    first = now.distance.argmin(axis=1)
    near = now.distance[n, first]
    nearest = now.behind[n, first] & (near < now.border) & (along[n, first] > OPPOSITE)
    nearest &= near >= least
    allowed = now.behind & (along > OPPOSITE) & (now.distance >= least[:, None])
    allowed &= now.distance <= most[:, None]
    allowed &= ~(before < (depth - slack)[:, None])
    second = np.where(allowed, now.distance, np.inf).argmin(axis=1)
    foot = np.where(nearest, first, second)
    normal = now.normal[n, foot]
    return Found(
        nearest | allowed.any(axis=1),
        now.distance[n, foot],
        normal,
        np.where(nearest[:, None], normal, guard),
    )


def step(shell: Shell, a: np.ndarray, b: np.ndarray, held: Held, pieces: int) -> Held:
    """Points that go straight from a to b, (n, 3) each, in so many pieces."""
    entry = shell.last_crossing(a, b)
    enters = entry.enters & ~np.isnan(entry.share)
    some = np.flatnonzero(held.on | enters)
    became = np.where(held.on, Becomes.OLD, Becomes.FREE)
    out = Held(held.on.copy(), held.depth.copy(), held.guard.copy(), held.normal.copy(), became)
    if len(some):
        own = Held(*(column[some] for column in out))
        own_entry = Entry(
            np.where(enters, entry.share, 2.0)[some], entry.normal[some], enters[some]
        )
        _follow(shell, (a[some], b[some]), own_entry, own, pieces)
        for column, values in zip(out, own, strict=True):
            column[some] = values
    return out


def _follow(
    shell: Shell, way: tuple[np.ndarray, np.ndarray], entry: Entry, held: Held, pieces: int
) -> None:
    """Change `held` to what it is at the end of the way; no entry has a share above 1."""
    (a, b), (on, depth, guard, normal, became) = way, held
    crossing = a + entry.share[:, None] * (b - a)
    came = np.flatnonzero(~on)  # from where they cross there is nothing to be looked at before
    on[came], became[came] = True, Becomes.NEW
    guard[came] = normal[came] = entry.normal[came]
    a = a.copy()
    a[came] = crossing[came]
    at_entry = entry.share.copy()
    at_entry[came] = 2.0
    shares = shares_of(a, b, pieces)
    before, last = a, shell.feet(a).distance
    for k in range(1, pieces + 1):
        now = b if k == pieces else a + shares[k][:, None] * (b - a)
        new = np.flatnonzero(~on & (at_entry <= shares[k]) & (at_entry > shares[k - 1]))
        rows = np.flatnonzero(on)
        if len(new):
            on[new], became[new], depth[new] = True, Becomes.NEW, 0.0
            guard[new] = normal[new] = entry.normal[new]
            rows = np.concatenate([rows, new])
            before, last = before.copy(), last.copy()
            before[new], last[new] = crossing[new], shell.feet(crossing[new]).distance
        feet = shell.feet(now)
        if len(rows):
            w = norm(now[rows] - before[rows])
            found = look(last[rows], _rows(feet, rows), depth[rows], guard[rows], w)
            keep = found.any
            if shell.closed:
                keep = keep & ~_outside(_rows(feet, rows))
            kept = rows[keep]
            depth[kept], normal[kept] = found.depth[keep], found.normal[keep]
            guard[kept] = found.guard[keep]
            gone = rows[~keep]
            if len(gone):
                own = Held(*(x[gone] for x in (on, depth, guard, normal, became)))
                own = _ended(shell, (before[gone], now[gone]), last[gone], own)
                on[gone], depth[gone], guard[gone] = own.on, own.depth, own.guard
                normal[gone], became[gone] = own.normal, own.became
        before, last = now, feet.distance


def shares_of(a: np.ndarray, b: np.ndarray, pieces: int) -> np.ndarray:
    """(pieces + 1, n) where to cut ways: the farther from the shell, the longer are the pieces."""
    length = np.maximum(norm(b - a), 1e-300)
    start = dot(a, b - a) / length
    ends = np.arcsinh(start), np.arcsinh(start + length)
    share = (np.sinh(np.linspace(*ends, pieces + 1)) - start) / length
    straight = np.linspace(0.0, 1.0, pieces + 1)[:, None]
    return np.where(length > 1e-3, share, straight)


def _outside(feet: Feet) -> np.ndarray:
    """Whether the nearest place has the point before it."""
    n = np.arange(len(feet.distance))
    return ~feet.behind[n, feet.distance.argmin(axis=1)]


def _ended(
    shell: Shell, piece: tuple[np.ndarray, np.ndarray], last: np.ndarray, held: Held
) -> Held:
    """Clause 3: what ends the hold on points within a piece = (from, to)."""
    a, b = piece
    length = norm(b - a)
    low, high = np.zeros(len(a)), np.ones(len(a))
    depth, normal, guard = held.depth.copy(), held.normal.copy(), held.guard.copy()
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        feet = shell.feet(a + middle[:, None] * (b - a))
        found = look(last, feet, held.depth, held.guard, middle * length)
        keep = found.any & ~_outside(feet) if shell.closed else found.any
        depth = np.where(keep, found.depth, depth)
        guard = np.where(keep[:, None], found.guard, guard)
        normal = np.where(keep[:, None], found.normal, normal)
        low, high = np.where(keep, middle, low), np.where(keep, high, middle)
    foot = a + low[:, None] * (b - a) + depth[:, None] * normal
    feet = shell.feet(b)
    out = (depth <= 1e-11) | (_outside(feet) if shell.closed else False)
    off = ~out & (shell.border(foot) <= 1e-9)
    along = np.einsum("nmk,nk->nm", feet.normal, guard)
    allowed = feet.behind & np.isfinite(feet.distance)
    facing = allowed & (along > OPPOSITE)
    if shell.closed:
        facing = np.where(facing.any(axis=1)[:, None], facing, allowed)
    far = np.where(facing, feet.distance, np.inf)
    other = far.argmin(axis=1)
    n = np.arange(len(a))
    again = ~out & ~off & facing.any(axis=1)
    became = np.select([out, off, again], [Becomes.RELEASED, Becomes.SLID_OFF, Becomes.REACQUIRED],
                       Becomes.ENDED)  # fmt: skip
    return Held(
        again,
        np.where(again, far[n, other], 0.0),
        np.where(again[:, None], guard, 0.0),
        np.where(again[:, None], feet.normal[n, other], 0.0),
        became,
    )


def along(held: Held, normal: np.ndarray) -> np.ndarray:
    """(n,) cosines of given normals with those of the rule."""
    return dot(held.normal, normal)
