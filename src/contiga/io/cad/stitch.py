"""Shared edges of untrimmed patches, from coinciding sides, for files without edges."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import Edge
from contiga.io.cad.loops import Loop, PCurve, Sides

COINCIDENT = 1e-9
"""Largest distance of coinciding sides, as a share of the whole size."""
SAMPLES = 9
"""Points at which two sides are compared."""


def side_curve(surface: NurbsSurface, side: int) -> NurbsCurve:
    """Return the natural side 0 … 3 = u0, u1, v0, v1 of a patch, with growing parameter."""
    (u0, u1), (v0, v1) = surface.domain
    if side < 2:
        return surface.isocurve(u=(u0, u1)[side])
    return surface.isocurve(v=(v0, v1)[side - 2])


def coincident_sides(
    surfaces: list[NurbsSurface],
) -> tuple[list[tuple[Loop, Sides]], dict[int, Edge]]:
    """Number the sides of `surfaces` so that coinciding ones share a number.

    Two sides coincide if `SAMPLES` points at the same shares of their domains, forwards or
    backwards, differ by at most `COINCIDENT` of the whole size in each coordinate. A side that is
    one point within that distance has no number (-1).

    Returns
    -------
    sides : per surface its four sides as a loop, ready for `Assembly.add_whole`
    edges : the edges by number, with the curve of the first side of each
    """
    side_curves = [side_curve(surface, side) for surface in surfaces for side in range(4)]
    sampled = np.array(
        [curve.evaluate(np.linspace(*curve.domain, SAMPLES)) for curve in side_curves]
    ).reshape(-1, SAMPLES, 3)
    size = float(np.ptp(sampled.reshape(-1, 3), axis=0).max()) if surfaces else 0.0
    near = COINCIDENT * size
    groups: dict[tuple[int, ...], list[int]] = {}
    number = np.arange(len(sampled))
    against = np.zeros(len(sampled), dtype=bool)
    collapsed = np.abs(sampled - sampled[:, :1]).max(axis=(1, 2)) <= near
    for k in np.flatnonzero(~collapsed).tolist():
        # The mean of both ends and the middle is the same from either end.
        middle = (sampled[k, 0] + sampled[k, -1] + sampled[k, SAMPLES // 2]) / 3.0
        cell = np.floor(middle / max(1e3 * near, 1e-300)).astype(np.int64)
        for step in np.ndindex(3, 3, 3):
            groups.setdefault(tuple(cell + np.array(step) - 1), []).append(k)
    for group in groups.values():
        for a, b in combinations(sorted(set(group)), 2):
            if number[b] != b:
                continue
            is_same = np.abs(sampled[a] - sampled[b]).max() <= near
            if is_same or np.abs(sampled[a] - sampled[b][::-1]).max() <= near:
                number[b] = number[a]
                against[b] = against[a] == is_same
    number[collapsed] = -1

    edges: dict[int, Edge] = {}
    sides = []
    for first in range(0, len(side_curves), 4):
        loop: Loop = []
        for k, curve in enumerate(side_curves[first : first + 4], start=first):
            if number[k] == k:
                edges[k] = Edge(curve, 0.0)
            loop.append(PCurve(curve, int(number[k]), bool(against[k]), 0.0))
        spans = [pcurve.curve.domain for pcurve in loop]
        sides.append((loop, Sides([0, 1, 2, 3], [False] * 4, spans)))
    return sides, edges
