"""The borders of a body's faces as loops of sides, and which of them are one edge.

A side is a p-curve of a loop, one side of a patch's natural rectangle, or the part of either that
one edge runs along. Sides of one edge get the same vertices; a side that is a single point in
space (a pole) gets one. What meets at a corner follows from the order in the loops alone, so
faces that share an edge fit whatever the gap between them is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.groups import groups_of
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.faces_like import FacesLike
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray, IntArray

NEAR = 1e-9
"""Places closer than this share of the body's size are one."""
GAP = 1e-5
"""p-curves without an edge that are shorter (share of the size) only close a gap in a loop."""
SNAP = 1e-9
"""Parameters closer than this share of a curve's domain are one."""
SAMPLES = 9
NATURAL = ((2, False), (1, False), (3, True), (0, True))
"""Natural sides around the rectangle, and whether each runs against its parameter."""
NO_EDGE = -1


class Path(NamedTuple):
    """A curve in the (u, v) of a patch, between two parameters."""

    patch: int
    curve: NurbsCurve | None
    """p-curve; None for a natural side."""
    side: int
    """0 … 3 = u0, u1, v0, v1 of a natural side."""
    start: float
    """Parameter where it starts in the sense of the loop; above `end` where it runs backwards."""
    end: float


class Side(NamedTuple):
    """A piece of a face's border."""

    path: Path
    edge: int
    """Group of sides that have the same vertices."""
    reversed: bool
    """Whether the loop runs against that edge."""


class Borders(NamedTuple):
    """Borders of all faces."""

    loops: list[list[list[Side]]]
    """By patch and loop."""
    curves: list[NurbsCurve | None]
    """By edge its curve in space; None where its first side stands for it."""
    tolerances: list[float]
    """By edge, length."""
    sides: list[list[Side]]
    """By edge."""
    pole: list[bool]
    """By edge, whether it is a single point."""


def path_points(path: Path, patch: NurbsSurface, share: FloatArray) -> FloatArray:
    """Return (n, 2) parameters of the patch at shares (n,) of the path from its start."""
    t = path.start + share * (path.end - path.start)
    t[share == 1.0] = path.end
    uv = np.empty((len(t), 2))
    if path.curve is not None:
        uv[:] = path.curve.evaluate(t)[:, :2]
    else:
        fixed = path.side // 2
        uv[:, fixed] = patch.domain[fixed][path.side % 2]
        uv[:, 1 - fixed] = t
    for k, (low, high) in enumerate(patch.domain):
        np.minimum(np.maximum(uv[:, k], low), high, out=uv[:, k])
    return uv


def borders_of(body: FacesLike) -> Borders:
    """Sides of all faces, those along one edge of `body` put together.

    Of a body that names no edges, natural sides that coincide are one edge.
    """
    uses = _uses(body)
    n = len(body.edges)
    tolerances = [max(edge.tolerance, edge.stated) for edge in body.edges]
    curves: list[NurbsCurve | None] = [edge.curve for edge in body.edges]
    result = Borders([], curves, tolerances, [[] for _ in range(n)], [False] * n)
    for k, (patch, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        if loops is None:
            whole = [Path(k, None, s, *_ends(patch, s, back)) for s, back in NATURAL]
            paths = [[(p, (-1, p.side)) for p in whole]]
        else:
            paths = [
                [(Path(k, c, -1, *c.domain), (m, i)) for i, c in enumerate(loop)]
                for m, loop in enumerate(loops)
            ]
        result.loops.append(
            [
                [s for p, key in loop for s in _cut(p, uses.get((k, *key), []), result)]
                for loop in paths
            ]
        )
    _mark_poles(body, result)
    if not body.edges:
        _pair(body, result)
    return result


def _ends(patch: NurbsSurface, side: int, back: bool) -> tuple[float, float]:
    low, high = patch.domain[1 - side // 2]
    return (high, low) if back else (low, high)


Use = tuple[int, bool, tuple[float, float] | None]


def _uses(body: FacesLike) -> dict[tuple[int, int, int], list[Use]]:
    uses: dict[tuple[int, int, int], list[Use]] = {}
    for e, edge in enumerate(body.edges):
        for i, use in enumerate(edge.uses):
            given = e, use.reversed, edge.span(i)
            uses.setdefault((use.patch, use.loop, use.index), []).append(given)
    return uses


def _cut(path: Path, uses: list[Use], result: Borders) -> list[Side]:
    """Sides along a path: parts that edges run along, and what is between these."""
    low, high = sorted((path.start, path.end))
    backward = path.start > path.end
    near = SNAP * (high - low)
    parts: list[tuple[float, float, int, bool]] = []
    at = low
    for e, against, span in sorted(uses, key=lambda use: use[2] or (low, high)):
        a, b = span or (low, high)
        a, b = max(a, at), min(b, high)
        if b - a <= near:
            continue
        if a - at > near:
            parts.append((at, a, NO_EDGE, False))
        else:
            a = at
        b = high if high - b <= near else b
        parts.append((a, b, e, against))
        at = b
    if high - at > near:
        parts.append((at, high, NO_EDGE, False))
    sides = []
    for a, b, e, against in reversed(parts) if backward else parts:
        part = path._replace(start=b, end=a) if backward else path._replace(start=a, end=b)
        if e == NO_EDGE:
            e, against = _new_edge(result), backward
        side = Side(part, e, against != backward)
        result.sides[e].append(side)
        sides.append(side)
    return sides


def _new_edge(result: Borders) -> int:
    result.curves.append(None)
    result.tolerances.append(0.0)
    result.sides.append([])
    result.pole.append(False)
    return len(result.sides) - 1


def _sampled(body: FacesLike, side: Side) -> FloatArray:
    patch = body.patches[side.path.patch]
    return patch.evaluate(path_points(side.path, patch, np.linspace(0.0, 1.0, SAMPLES)))


def _mark_poles(body: FacesLike, result: Borders) -> None:
    for e, sides in enumerate(result.sides):
        if result.curves[e] is None and sides:
            small = (NEAR if sides[0].path.curve is None else GAP) * body.size
            result.pole[e] = bool(np.ptp(_sampled(body, sides[0]), axis=0).max() <= small)


def _pair(body: FacesLike, result: Borders) -> None:
    """Make one edge of natural sides that run along each other, parameter by parameter."""
    near = NEAR * body.size
    alone = [
        (e, sides[0], _sampled(body, sides[0]))
        for e, sides in enumerate(result.sides)
        if not result.pole[e] and sides[0].path.curve is None
    ]
    kept: list[tuple[int, FloatArray]] = []
    new: dict[int, tuple[int, bool]] = {}
    for e, side, points in alone:
        for other, q in kept:
            same = np.abs(points - q).max() <= near
            if same or np.abs(points - q[::-1]).max() <= near:
                joined = side._replace(edge=other, reversed=not same)
                result.sides[other].append(joined)
                result.sides[e].clear()
                new[e] = (other, not same)
                break
        else:
            kept.append((e, points))
            new[e] = (e, False)
            result.sides[e][0] = side._replace(reversed=False)
    for loops in result.loops:
        for loop in loops:
            loop[:] = [
                s._replace(edge=new[s.edge][0], reversed=new[s.edge][1]) if s.edge in new else s
                for s in loop
            ]


def corners(result: Borders) -> IntArray:
    """Return (e, 2) number of the corner at the start and the end of each edge.

    A corner is where one side of a loop ends and the next one starts.
    """
    met = [(2 * e, 2 * e + 1) for e, is_pole in enumerate(result.pole) if is_pole]
    for loop in (loop for loops in result.loops for loop in loops):
        for side, after in zip(loop, loop[1:] + loop[:1], strict=True):
            met.append((2 * side.edge + (not side.reversed), 2 * after.edge + after.reversed))
    first, second = np.array(met, np.int64).reshape(-1, 2).T
    return groups_of(first, second, 2 * len(result.sides)).reshape(-1, 2)
