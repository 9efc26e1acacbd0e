"""Borders of a body's faces as loops of sides, grouped by the edge they run along.

A side is a p-curve of a loop, one side of a patch's natural rectangle, or the part of either that
one edge runs along. Sides of one edge get the same vertices; a side that is a single point in
space (a pole) gets one. The order in the loops alone decides which sides meet at a corner, so
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

POINT_TOL = 1e-9
"""Points closer than this share of the body's size are one."""
GAP_TOL = 1e-5
"""p-curves without an edge that are shorter (share of the size) only close a gap in a loop."""
PARAMETER_TOL = 1e-9
"""Parameters closer than this share of a curve's domain are one."""
N_SAMPLES = 9
"""Samples of a side that are compared with another side."""
NATURAL_SIDES = ((2, False), (1, False), (3, True), (0, True))
"""Natural sides around the rectangle, and whether each runs against its parameter."""
NO_EDGE = -1


class Path(NamedTuple):
    """A curve in the (u, v) of a patch, between two parameters."""

    patch: int
    """Number of the patch."""
    curve: NurbsCurve | None
    """p-curve; None for a natural side."""
    side: int
    """0 … 3 = u0, u1, v0, v1 of a natural side; −1 for a p-curve."""
    start: float
    """Parameter at the start in the sense of the loop; above `end` if the path runs backwards."""
    end: float
    """Parameter at the end."""


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
    """By edge its curve in space; None if its first side defines it."""
    tolerances: list[float]
    """By edge, length."""
    sides: list[list[Side]]
    """By edge."""
    pole: list[bool]
    """By edge, whether it is a single point."""


def path_points(path: Path, patch: NurbsSurface, share: FloatArray) -> FloatArray:
    """Return (n, 2) parameters of the patch at shares (n,) of the path from its start.

    They are clipped to the patch's domain.
    """
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


Use = tuple[int, bool, tuple[float, float] | None]
"""Edge, whether the path runs against its curve, and the parameters it runs along; None: all."""


def borders_of(body: FacesLike) -> Borders:
    """Return the sides of all faces, grouped by the edge of `body` they run along.

    A part of a path that no edge runs along is an edge of its own. It is a pole if samples of it
    are within `POINT_TOL` of the body's size in x, y and z (`GAP_TOL` on a p-curve). If the body
    names no edges, natural sides that coincide are one edge.
    """
    uses: dict[tuple[int, int, int], list[Use]] = {}
    for e, edge in enumerate(body.edges):
        for i, use in enumerate(edge.uses):
            uses_of_path = uses.setdefault((use.patch, use.loop, use.index), [])
            uses_of_path.append((e, use.reversed, edge.span(i)))
    n = len(body.edges)
    tolerances = [max(edge.tolerance, edge.stated) for edge in body.edges]
    curves: list[NurbsCurve | None] = [edge.curve for edge in body.edges]
    borders = Borders([], curves, tolerances, [[] for _ in range(n)], [False] * n)
    for k, (patch, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        if loops is None:
            paths = []
            for side, is_backward in NATURAL_SIDES:
                low, high = patch.domain[1 - side // 2]
                path = Path(k, None, side, *((high, low) if is_backward else (low, high)))
                paths.append((path, (-1, side)))
            path_loops = [paths]
        else:
            path_loops = [
                [(Path(k, c, -1, *c.domain), (m, i)) for i, c in enumerate(loop)]
                for m, loop in enumerate(loops)
            ]
        borders.loops.append(
            [
                [s for p, key in loop for s in _split_path(p, uses.get((k, *key), []), borders)]
                for loop in path_loops
            ]
        )
    for e, sides in enumerate(borders.sides):
        if borders.curves[e] is None and sides:
            size = np.ptp(_samples(body, sides[0]), axis=0).max()
            tol = (POINT_TOL if sides[0].path.curve is None else GAP_TOL) * body.size
            borders.pole[e] = bool(size <= tol)
    if not body.edges:
        _pair_natural_sides(body, borders)
    return borders


def _split_path(path: Path, uses: list[Use], borders: Borders) -> list[Side]:
    """Return the sides of a path, in its sense: parts that edges run along, and parts between.

    Of parts that overlap the earlier one is kept in full; parts up to `PARAMETER_TOL` long are
    dropped. Sides are added to `borders`, and each part between gets a new edge there.
    """
    low, high = sorted((path.start, path.end))
    is_backward = path.start > path.end
    tol = PARAMETER_TOL * (high - low)
    parts: list[tuple[float, float, int, bool]] = []
    end = low
    for e, against, span in sorted(uses, key=lambda use: use[2] or (low, high)):
        a, b = span or (low, high)
        a, b = max(a, end), min(b, high)
        if b - a <= tol:
            continue
        if a - end > tol:
            parts.append((end, a, NO_EDGE, False))
        else:
            a = end
        b = high if high - b <= tol else b
        parts.append((a, b, e, against))
        end = b
    if high - end > tol:
        parts.append((end, high, NO_EDGE, False))
    sides = []
    for a, b, e, against in reversed(parts) if is_backward else parts:
        part = path._replace(start=b, end=a) if is_backward else path._replace(start=a, end=b)
        if e == NO_EDGE:
            e, against = len(borders.sides), is_backward
            borders.curves.append(None)
            borders.tolerances.append(0.0)
            borders.sides.append([])
            borders.pole.append(False)
        side = Side(part, e, against != is_backward)
        borders.sides[e].append(side)
        sides.append(side)
    return sides


def _samples(body: FacesLike, side: Side) -> FloatArray:
    """Return (N_SAMPLES, 3) points of a side, at equal steps of its parameter from start to end."""
    patch = body.patches[side.path.patch]
    return patch.evaluate(path_points(side.path, patch, np.linspace(0.0, 1.0, N_SAMPLES)))


def _pair_natural_sides(body: FacesLike, borders: Borders) -> None:
    """Make one edge of natural sides that run along each other; write it to `borders`.

    Their `N_SAMPLES` samples agree to `POINT_TOL` of the body's size, in one order or the other; a
    side joins the first edge that fits. The `loops` and `sides` change; the edge that a side leaves
    stays, without sides. Poles are left out.
    """
    tol = POINT_TOL * body.size
    natural = [
        (e, sides[0], _samples(body, sides[0]))
        for e, sides in enumerate(borders.sides)
        if not borders.pole[e] and sides[0].path.curve is None
    ]
    unpaired: list[tuple[int, FloatArray]] = []
    new_edges: dict[int, tuple[int, bool]] = {}
    for e, side, points in natural:
        for partner, q in unpaired:
            same_sense = np.abs(points - q).max() <= tol
            if same_sense or np.abs(points - q[::-1]).max() <= tol:
                paired = side._replace(edge=partner, reversed=not same_sense)
                borders.sides[partner].append(paired)
                borders.sides[e].clear()
                new_edges[e] = (partner, not same_sense)
                break
        else:
            unpaired.append((e, points))
            new_edges[e] = (e, False)
            borders.sides[e][0] = side._replace(reversed=False)
    for loop in (loop for loops in borders.loops for loop in loops):
        for i, side in enumerate(loop):
            if side.edge in new_edges:
                e, is_reversed = new_edges[side.edge]
                loop[i] = side._replace(edge=e, reversed=is_reversed)


def edge_corners(borders: Borders) -> IntArray:
    """Return (e, 2) the numbers of the corners at the start and the end of each edge.

    Ends are one corner if a side of a loop ends in one and the next side starts in the other; both
    ends of a pole are one.
    """
    meeting = [(2 * e, 2 * e + 1) for e, is_pole in enumerate(borders.pole) if is_pole]
    for loop in (loop for loops in borders.loops for loop in loops):
        for side, after in zip(loop, loop[1:] + loop[:1], strict=True):
            meeting.append((2 * side.edge + (not side.reversed), 2 * after.edge + after.reversed))
    first, second = np.array(meeting, np.int64).reshape(-1, 2).T
    return groups_of(first, second, 2 * len(borders.sides)).reshape(-1, 2)
